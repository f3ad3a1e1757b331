"""The RL half: ids, infos, observations of agents, wrappers, seeds."""

from __future__ import annotations

import gymnasium as gym
import numpy as np
import pytest

pytest.importorskip("torch")

import torch
from helpers import made, shapes

import engram
import engram.mikasa as mikasa
import engram.mikasa.rl as rl
from engram.mikasa import drawing

B = 2
# Class, length of states, type and second dimension of the answer, by id.
TOUCH = "obj_to_goal_pos is_obj_placed is_robot_static"
COLORS = "obj_to_goal_pos is_robot_static"
TABLE = {
    "ShellGameTouch-v0": ("ShellGameTouchEnv", 40, TOUCH),
    "ShellGamePush-v0": ("ShellGamePushEnv", 43, TOUCH),
    "ShellGamePick-v0": ("ShellGamePickEnv", 44, f"{TOUCH} is_grasped"),
    "InterceptSlow-v0": ("InterceptSlowEnv", 50, ""),
    "InterceptMedium-v0": ("InterceptMediumEnv", 50, ""),
    "InterceptFast-v0": ("InterceptFastEnv", 50, ""),
    "InterceptGrabSlow-v0": ("InterceptGrabSlowEnv", 49, "is_ball_grasped is_robot_static"),
    "InterceptGrabMedium-v0": ("InterceptGrabMediumEnv", 49, "is_ball_grasped is_robot_static"),
    "InterceptGrabFast-v0": ("InterceptGrabFastEnv", 49, "is_ball_grasped is_robot_static"),
    "RotateLenientPos-v0": ("RotateLenientEnvPos", 33, "relative_angle y_angle_error"),
    "RotateLenientPosNeg-v0": ("RotateLenientEnvPosNeg", 33, "relative_angle y_angle_error"),
    "RotateStrictPos-v0": (
        "RotateStrictEnvPos", 33, "relative_angle x_pos_error y_angle_error y_pos_error",
    ),
    "RotateStrictPosNeg-v0": (
        "RotateStrictEnvPosNeg", 33, "relative_angle x_pos_error y_angle_error y_pos_error",
    ),
    "TakeItBack-v0": ("TakeItBackEnv", 39, "goal_achieved goal_reached_status"),
    "RememberColor3-v0": ("RememberColor3Env", 35, TOUCH),
    "RememberColor5-v0": ("RememberColor5Env", 41, TOUCH),
    "RememberColor9-v0": ("RememberColor9Env", 53, TOUCH),
    "RememberShape3-v0": ("RememberShape3Env", 35, TOUCH),
    "RememberShape5-v0": ("RememberShape6Env", 41, TOUCH),
    "RememberShape9-v0": ("RememberShape9Env", 53, TOUCH),
    "RememberShapeAndColor3x2-v0": ("RememberShapeAndColor3x2Env", 45, TOUCH),
    "RememberShapeAndColor3x3-v0": ("RememberShapeAndColor3x3Env", 54, TOUCH),
    "RememberShapeAndColor5x3-v0": ("RememberShapeAndColor5x3Env", 72, TOUCH),
    **{
        f"{kind}OfColors{n}-v0": (f"{kind}OfColors{n}Env", 82 + n, COLORS)
        for kind in ("Bunch", "Seq", "Chain")
        for n in (3, 5, 7)
    },
}  # fmt: skip
IDS = [task["id"] for task in engram.list() if task["split"] == "rl"]
ORACLES = {
    "Intercept": "float32 (2, 3)",
    "TakeItBack": "float32 (2, 3)",
    "Rotate": "float32 (2,)",
    "RememberShapeAndColor": "uint8 (2, 2)",
    **{f"{k}OfColors{n}": f"uint8 (2, {n})" for k in ("Bunch", "Seq", "Chain") for n in (3, 5, 7)},
}


def wrapped(id, num_envs=B, overlays=(), ignore_terminations=True, flags=None, **keywords):
    """An environment as the original's scripts wrap it."""
    env = gym.make(id, num_envs=num_envs, threads=1, **keywords)
    env = rl.StateOnlyTensorToDictWrapper(env)
    env = rl.InitialZeroActionWrapper(env, n_initial_steps=0)
    for overlay in overlays:
        env = overlay(env)
    pictures = keywords.get("obs_mode") == "rgb"
    given = {"rgb": pictures, "depth": False, "state": not pictures, **(flags or {})}
    env = mikasa.FlattenRGBDObservationWrapper(env, **given)
    return mikasa.ManiSkillVectorEnv(
        env, ignore_terminations=ignore_terminations, record_metrics=True
    )


# --- ids ---


def test_ids_and_classes():
    assert set(IDS) <= set(TABLE)
    for id in IDS:
        name, *_ = TABLE[id]
        assert mikasa.registration.REGISTERED[id] is getattr(rl, name)
        assert name not in mikasa.__all__
    assert {name for name, *_ in TABLE.values()} >= {
        cls.__name__ for cls in map(mikasa.registration.REGISTERED.get, IDS)
    }


@pytest.mark.parametrize("id", IDS)
def test_observations_and_infos(id):
    _, width, own = TABLE[id]
    with made(id, num_envs=B, control_mode=None) as env:
        observation, info = env.reset(seed=1)
        assert env.unwrapped.control_mode == "pd_joint_delta_pos"
        assert env.action_space.shape == (B, 8)
        assert shapes(observation) == f"float32 ({B}, {width})"
        for _ in range(3):
            _, reward, terminated, truncated, info = env.step(env.action_space.sample())
        seen = shapes(info)
        answer = next((kind for name, kind in ORACLES.items() if id.startswith(name)), "uint8 (2,)")
        assert seen.pop("oracle_info") == answer
        cue = "float16 (2,)" if id.startswith("Rotate") else None
        assert seen.pop("task_cue") == cue
        assert seen.pop("elapsed_steps") == "int32 (2,)"
        assert seen.pop("success") == "bool (2,)"
        terms = seen.pop("reward_dict")
        assert terms
        assert not any("displacement" in name or "smooth" in name for name in terms)
        assert " ".join(seen) == own  # no instruction
        assert shapes(reward) == "float32 (2,)"
        assert shapes(terminated) == shapes(truncated) == "bool (2,)"
        base = env.unwrapped
        for name in ("LANGUAGE_INSTRUCTION", "cue_steps_per_env", "empty_steps_per_env"):
            assert not hasattr(base, name), name
        assert not hasattr(type(base), "LANGUAGE_INSTRUCTION")


# --- observations of agents ---

COLOR = "RememberColor3-v0"
ROTATE = "RotateLenientPos-v0"
PICTURES = {"rgb": "uint8 (2, 128, 128, 6)"}
JOINTS = {"joints": "float32 (2, 25)"}


@pytest.mark.parametrize(
    ("flags", "expected"),
    [
        ({}, PICTURES),
        ({"joints": True}, {**JOINTS, **PICTURES}),
        ({"oracle": True}, {"oracle_info": "uint8 (2, 1)", **PICTURES}),
        ({"joints": True, "joints_name": "proprio"}, {"proprio": "float32 (2, 25)", **PICTURES}),
    ],
    ids=["rgb", "joints", "oracle", "proprio"],
)
def test_what_agents_read(flags, expected):
    env = wrapped(COLOR, obs_mode="rgb", flags=flags)
    observation, _ = env.reset(seed=0)
    assert shapes(observation) == expected
    assert list(observation) == list(expected)
    assert env.single_observation_space["rgb"].shape == (128, 128, 6)
    agent = mikasa.Agent(env, observation)
    assert agent.get_action(observation).shape == (B, 8)
    env.close()


def test_joints_are_tool_pose_then_positions_then_velocities():
    env = wrapped(COLOR, obs_mode="rgb", flags={"joints": True})
    env.reset(seed=0)
    for _ in range(3):
        observation, *_ = env.step(torch.rand(B, 8) * 2 - 1)
    robot = env.base_env.agent.robot
    expected = [env.base_env.agent.tcp.pose.raw_pose, robot.get_qpos(), robot.get_qvel()]
    assert torch.equal(observation["joints"], torch.cat(expected, dim=1))
    env.close()


def test_states_of_agents():
    env = wrapped(COLOR, obs_mode="state")
    observation, _ = env.reset(seed=0)
    assert shapes(observation) == {"state": "float32 (2, 35)"}
    assert mikasa.AgentStateOnly(env).get_action(observation).shape == (B, 8)
    env.close()


@pytest.mark.skipif(ROTATE not in IDS, reason="no such task")
def test_rotate_has_its_cue():
    env = wrapped(ROTATE, obs_mode="state")
    observation, _ = env.reset(seed=0)
    assert shapes(observation) == {"state": "float32 (2, 33)", "task_cue": "float16 (2, 1)"}
    env.close()
    env = wrapped(ROTATE, obs_mode="rgb", flags={"joints": True})
    observation, _ = env.reset(seed=0)
    assert list(observation) == ["task_cue", "joints", "rgb"]
    env.close()


# --- episodes ---


def test_episodes_of_published_training_go_on_to_the_horizon():
    """As terminations are ignored; success in any step counts."""
    env = wrapped(COLOR, num_envs=4, obs_mode="state")
    oracle = engram.make_vec(COLOR, 4, threads=1, rules="original", terminate_on_success=False)
    seeds = [3, 4, 5, 6]
    env.reset(seed=seeds)
    oracle.reset(seed=seeds)
    ended = []
    for _ in range(60):
        action = oracle.act("oracle")
        oracle.step(action)
        _, _, terminated, truncated, info = env.step(torch.from_numpy(action))
        ended.append(bool((terminated | truncated).any()))
    assert ended == [False] * 59 + [True]
    assert info["final_info"]["episode"]["success_once"].all()
    assert info["final_info"]["episode"]["episode_len"].tolist() == [60] * 4
    oracle.close()
    env.close()


def test_success_terminates():
    env = gym.make(COLOR, num_envs=1, obs_mode="state", threads=1)
    oracle = engram.make_vec(COLOR, 1, threads=1, rules="original")
    env.reset(seed=3)
    oracle.reset(seed=3)
    for _ in range(60):
        action = oracle.act("oracle")
        oracle.step(action)
        _, reward, terminated, _, info = env.step(torch.from_numpy(action))
        assert terminated.tolist() == info["success"].tolist()
        if terminated.any():
            break
    assert terminated.all()
    assert reward.tolist() == [1.0]
    oracle.close()
    env.close()


def test_batches_of_following_seeds_share_no_episodes():
    def states(seed, num_envs):
        with made("ShellGameTouch-v0", num_envs=num_envs, control_mode=None) as env:
            return env.reset(seed=seed)[0]

    first, second = states(0, 8), states(1, 8)
    rows = {tuple(row.tolist()) for row in torch.cat([first, second])}
    assert len(rows) == 16
    assert torch.equal(states(0, 3), first[:3])  # the same for any size of the batch
    assert torch.equal(states([1], 1), second[:1])
    assert torch.equal(states(0, 8), first)


def test_negative_seeds_are_refused():
    with made("ShellGameTouch-v0", num_envs=2) as env, pytest.raises(engram.Error):
        env.reset(seed=-1)


# --- constants ---


def test_lengths_of_phases():
    assert rl.ShellGameTouchEnv.TIME_OFFSET == rl.RememberColor3Env.TIME_OFFSET == 5

    class Longer(rl.ShellGameTouchEnv):
        TIME_OFFSET = 9

    rl.register_env("ShellGameTouch-Longer-v0", max_episode_steps=95)(Longer)
    with made("ShellGameTouch-Longer-v0", num_envs=1, control_mode=None) as env:
        assert env.unwrapped.TIME_OFFSET == 9
        observation, _ = env.reset(seed=0)
        hidden = []
        for _ in range(11):
            hidden.append(float(observation[0, 27]) > 100)  # height of the mug over the ball
            observation, *_ = env.step(torch.zeros(1, 8))
        assert hidden == [True] * 9 + [False] * 2
    with made(COLOR, num_envs=1, delta_time=7) as env:
        assert env.unwrapped.delta_time == 7
    with pytest.raises(TypeError, match="delta_time"):
        gym.make("RememberColor3-VLA-v0", delta_time=7)

    class Twice(rl.ShellGameTouchEnv):
        TIME_OFFSET = 9
        CUE_PHASE_STEPS = (1, 5)

    with pytest.raises(engram.InvalidArgumentError, match=r"TIME_OFFSET=9 and CUE_PHASE_STEPS="):
        rl.register_env("ShellGameTouch-Twice-v0", max_episode_steps=95)(Twice)


def test_there_is_no_instruction():
    touch = rl.ShellGameTouchEnv
    assert "LANGUAGE_INSTRUCTION" not in dir(touch)
    assert "TIME_OFFSET" in dir(touch)
    for name in ("LANGUAGE_INSTRUCTION", "LANGUAGE_INSTRUCTION_TEMPLATE"):
        with pytest.raises(engram.UnknownIdError, match=r"did you mean (?!LANGUAGE)"):
            setattr(touch, name, "Touch it.")


# --- overlays ---


def changed_rows(id, overlay, steps=2):
    """First and last row that an overlay changes, and by how much it brightens each pixel there."""
    pictures = []
    for use in (False, True):
        env = gym.make(id, num_envs=1, render_mode="rgb_array", threads=1)
        env = overlay(env) if use else env
        env.reset(seed=[2])
        for _ in range(steps):
            env.step(torch.zeros(1, 8))
        pictures.append(np.asarray(env.render())[0])
        env.close()
    different = (pictures[0] != pictures[1]).any(-1)
    rows = np.flatnonzero(different.any(1))
    before, after = (picture.max(-1)[different].astype(int) for picture in pictures)
    return (rows.min(), rows.max()), after - before


@pytest.mark.parametrize(
    ("overlay", "id", "baseline"),
    [
        ("RenderStepInfoWrapper", COLOR, 30),
        ("RenderRewardInfoWrapper", COLOR, 120),
        ("RememberColorInfoWrapper", COLOR, 60),
        ("RememberShapeInfoWrapper", "RememberShape3-v0", 60),
        ("RememberShapeAndColorInfoWrapper", "RememberShapeAndColor3x3-v0", 60),
        ("ShellGameRenderCupInfoWrapper", "ShellGameTouch-v0", 60),
    ],
)
def test_overlays_are_where_the_original_has_them(overlay, id, baseline, monkeypatch):
    monkeypatch.setenv("MIKASA_DISABLE_REWARD_OVERLAY", "1")  # of the VLA half only
    (top, bottom), brighter = changed_rows(id, getattr(rl, overlay))
    assert baseline - 24 <= top < baseline - 12
    assert baseline - 2 <= bottom <= baseline + 8
    assert brighter.min() > -20  # no outline, which would be darker by 90


def test_debug_overlay_has_a_line_for_each_term(monkeypatch):
    monkeypatch.setenv("MIKASA_DISABLE_REWARD_OVERLAY", "1")
    (top, bottom), _ = changed_rows(COLOR, rl.DebugRewardWrapper)
    terms = len(engram.describe(COLOR)["reward_terms"])
    assert 155 <= top <= 170
    assert abs(bottom - (170 + 20 * (terms - 1))) <= 6


def test_overlays_write_names_of_colours(monkeypatch):
    written = []
    monkeypatch.setattr(
        drawing, "put_text", lambda image, text, *args, **keywords: written.append(text)
    )
    changed = [rl.RememberColorInfoWrapper, rl.RememberShapeAndColorInfoWrapper]
    for id, overlay in zip((COLOR, "RememberShapeAndColor3x3-v0"), changed):
        env = overlay(gym.make(id, num_envs=1, render_mode="rgb_array", threads=1))
        _, info = env.reset(seed=2)
        env.render()
        answer = info["oracle_info"][0].tolist()
        if id == COLOR:
            assert written == [f"Target: {env.unwrapped.COLOR_MAPPING[answer][0]}"]
        else:
            shape, color = answer
            assert written[1:] == [
                "Target:", ["Red", "Green", "Blue"][color], env.unwrapped.BASE_SHAPES[shape],
            ]  # fmt: skip
        env.close()
