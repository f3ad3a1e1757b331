"""All 97 VLA ids: keys, types and shapes of what comes out, and attributes."""

from __future__ import annotations

import pytest

pytest.importorskip("torch")

import gymnasium as gym
import torch
from conftest import registered_ids
from expected import CUE_ALONE, CUE_AND_EMPTY, CUES, ORACLES, SHARED, own_infos, term_types
from helpers import as_arrays, made, shapes, tasks

import engram

IDS = registered_ids()
B = 2


def width(kind, env):
    return getattr(env.unwrapped, kind) if isinstance(kind, str) else kind


def shaped(entry, env):
    dtype, second = entry
    second = width(second, env)
    return f"{dtype} ({B}, {second})" if second else f"{dtype} ({B},)"


def assert_infos(info, env, family):
    seen = shapes(info)
    own = {
        "b": f"bool ({B},)",
        "f": f"float32 ({B},)",
        "i": f"int64 ({B},)",
        "3": f"float32 ({B}, 3)",
    }
    for name, kind in own_infos(family):
        if kind == "c":
            assert seen.pop(name) == f"bool ({B}, {env.unwrapped.NUM_CHECKPOINTS})"
        else:
            assert seen.pop(name) == own[kind], name
    assert seen.pop("elapsed_steps") == f"int32 ({B},)"
    assert seen.pop("success") == f"bool ({B},)"
    assert seen.pop("oracle_info") == shaped(ORACLES.get(family, ("uint8", 0)), env)
    cue = seen.pop("task_cue")
    assert cue == (shaped(CUES[family], env) if family in CUES else None)
    text = seen.pop("language_instruction")
    if family.startswith("Rotate"):
        assert len(text) == B
        assert all("degrees" in one for one in text)
    else:
        assert isinstance(text, str)
        assert text
    terms = seen.pop("reward_dict")
    if terms is not None:
        letters = {"b": "bool", "i": "int64"}
        expected = {name: letters[kind] for name, kind in term_types(family)}
        for name, seen_type in terms.items():
            assert seen_type == f"{expected.get(name, 'float32')} ({B},)", name
    seen.pop("reconfigure", None)
    assert seen == {}
    assert set(SHARED.split()) <= set(info)


def assert_phases(env, family):
    base = env.unwrapped
    has_cue = family in CUE_AND_EMPTY or family in CUE_ALONE
    assert hasattr(base, "cue_steps_per_env") == has_cue
    assert hasattr(base, "empty_steps_per_env") == (family in CUE_AND_EMPTY)
    for name in ("cue_steps_per_env", "empty_steps_per_env"):
        if hasattr(base, name):
            assert shapes(getattr(base, name)) == f"int64 ({B},)"


def test_there_are_97():
    assert len(IDS) == 97
    assert set(IDS) <= set(tasks())  # besides, what other tests have registered


@pytest.mark.parametrize("id", IDS)
def test_state_dict(id):
    family = tasks()[id]
    with made(id, num_envs=B, obs_mode="state_dict") as env:
        observation, info = env.reset(seed=3)
        assert_infos(info, env, family)
        assert info["reward_dict"] is None
        assert isinstance(info["reconfigure"], bool)
        assert list(observation) == ["agent", "extra"]
        assert shapes(observation["agent"]) == {
            "qpos": f"float32 ({B}, 9)", "qvel": f"float32 ({B}, 9)",
        }  # fmt: skip
        extra = shapes(observation["extra"])
        assert next(iter(extra)) == "tcp_pose"
        assert extra["oracle_info"] == shaped(ORACLES.get(family, ("uint8", 0)), env)
        kinds = {"b": "bool", "f": "float32", "i": "int64"}
        for name, kind in own_infos(family):
            if name in extra and kind in kinds:
                assert extra[name] == f"{kinds[kind]} ({B},)", name
        for name, seen in extra.items():
            if name.endswith("_pose") and not name.startswith(("goal_", "cube_", "battery_")):
                assert seen == f"float32 ({B}, 7)", name
            elif name.startswith(("touched_", "next_target_")) or name.endswith("_in_seq"):
                assert seen == f"bool ({B},)", name
        assert env.observation_space.contains(as_arrays(observation))
        for _ in range(3):
            observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
        assert_infos(info, env, family)
        assert info["reward_dict"]
        assert shapes(reward) == f"float32 ({B},)"
        assert shapes(terminated) == shapes(truncated) == f"bool ({B},)"
        assert info["elapsed_steps"].tolist() == [3, 3]
        assert_phases(env, family)


@pytest.mark.parametrize("id", IDS)
def test_state_row(id):
    with made(id, num_envs=1, obs_mode="state", control_mode=None) as env:
        observation, _ = env.reset(seed=3)
        size = engram.describe(id)["state_dim"]
        assert shapes(observation) == f"float32 (1, {size})"
        assert env.action_space.shape == (8,)  # pd_joint_delta_pos, without a batch
        assert gym.spec(id).max_episode_steps == env.spec.max_episode_steps
        assert env.spec.id == env.unwrapped.spec.id == id
        same = made(id, num_envs=1, obs_mode="state_dict", control_mode=None)
        with same as other:
            parts, _ = other.reset(seed=3)
            flat = engram.mikasa.flatten_state_dict(parts, use_torch=True)
        answers = observation < 0  # nothing, -1 in rows, is 255 among bytes
        assert torch.equal(flat[~answers], observation[~answers])


def test_pictures_and_nothing():
    id = "RotateStrictPos-VLA-v0"
    camera = {
        "extrinsic_cv": f"float32 ({B}, 3, 4)",
        "cam2world_gl": f"float32 ({B}, 4, 4)",
        "intrinsic_cv": f"float32 ({B}, 3, 3)",
    }
    picture = {"rgb": f"uint8 ({B}, 128, 128, 3)"}
    with made(id, num_envs=B, obs_mode="rgb") as env:
        observation, info = env.reset(seed=1)
        assert shapes(observation) == {
            "agent": {"qpos": f"float32 ({B}, 9)", "qvel": f"float32 ({B}, 9)"},
            "extra": {"tcp_pose": f"float32 ({B}, 7)"},
            "sensor_param": {"base_camera": camera, "hand_camera": camera},
            "sensor_data": {"base_camera": picture, "hand_camera": picture},
        }
        assert list(observation["sensor_data"]) == ["base_camera", "hand_camera"]
        assert env.observation_space.contains(as_arrays(observation))
        assert_infos(info, env, "RotateStrict")
    with made(id, num_envs=B, obs_mode="none") as env:
        assert env.reset(seed=1)[0] == {}
        assert env.step(env.action_space.sample())[0] == {}


def test_state_and_pictures_follow_the_same_course():
    id = "RememberColor3-VLA-v0"
    with (
        made(id, num_envs=3, obs_mode="state_dict") as one,
        made(id, num_envs=3, obs_mode="rgb") as other,
    ):
        for env in (one, other):
            env.reset(seed=[5, 6, 7])
        for _ in range(5):
            action = torch.rand(3, 7) * 2 - 1
            first, second = one.step(action), other.step(action)
            assert torch.equal(first[1], second[1])
            for name in ("qpos", "qvel"):
                assert torch.equal(first[0]["agent"][name], second[0]["agent"][name])
            assert torch.equal(first[0]["extra"]["tcp_pose"], second[0]["extra"]["tcp_pose"])
