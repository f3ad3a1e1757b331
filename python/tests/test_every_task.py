"""Invariants of every task: observations are in their spaces, infos match the description."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from conftest import assert_same, registered_ids

import engram
from engram.envs.spaces import take

NUM_ENVS = 2
# Outputs that `step` returns by themselves, not in infos; "observation" stands for all of them.
RETURNED = {"observation", "reward", "terminated", "truncated"}


def one_id_per_family() -> list[str]:
    return list({task["family"]: task["id"] for task in reversed(engram.list())}.values())[::-1]


def flat_fields(fields: list[dict[str, Any]]) -> list[tuple[str, int]]:
    return [(field["name"], field["width"]) for field in fields]


def check_in_space(env: engram.VectorEnv, obs: Any) -> None:
    """The batch's observation and each environment's, type and shape of every part included."""
    assert env.observation_space.contains(obs)
    for i in range(env.num_envs):
        assert env.single_observation_space.contains(take(obs, i))
    if not isinstance(obs, dict):
        assert obs.dtype == env.observation_space.dtype
        return
    assert set(env.observation_space) == set(obs)
    for key, part in obs.items():
        if isinstance(part, np.ndarray):
            assert part.dtype == env.observation_space[key].dtype, key
            assert part.shape == env.observation_space[key].shape, key


def check_infos(info: dict[str, Any], described: dict[str, Any], in_observation: set[str]) -> None:
    """Names, types and widths are those of the description, and every name has its mask."""
    outputs = {o["name"]: o for o in described["outputs"]}
    expected = set(outputs) - RETURNED - in_observation
    names = [name for name in info if not name.startswith("_")]
    assert set(names) == expected | {"language_instruction"}
    assert set(info) == {*names, *(f"_{name}" for name in names)}
    for name in names:
        mask = info[f"_{name}"]
        assert mask.dtype == np.bool_, name
        assert mask.shape == (NUM_ENVS,), name
    for name in expected:
        width = outputs[name]["width"]
        assert str(info[name].dtype) == outputs[name]["dtype"], name
        assert info[name].shape == ((NUM_ENVS,) if width == 1 else (NUM_ENVS, width)), name


@pytest.mark.parametrize("id", registered_ids())
def test_state_observations_and_infos(make, id):
    described = engram.describe(id)
    rows, parts = (
        make(id, NUM_ENVS, obs_mode=mode, privileged=True, language_in_info=True)
        for mode in ("state", "state_dict")
    )
    assert rows.single_observation_space.shape == (described["state_dim"],)
    obs, info = rows.reset(seed=5)
    dicts, _ = parts.reset(seed=5)
    fields = [field for part in dicts.values() for field in part.items()]
    assert [(name, a.shape[1]) for name, a in fields] == flat_fields(described["state_fields"])
    for step in range(4):
        if step > 0:
            actions = rows.act("oracle")
            assert rows.action_space.contains(actions)
            obs, *_, info = rows.step(actions)
            dicts = parts.step(actions)[0]
        check_in_space(rows, obs)
        check_in_space(parts, dicts)
        check_infos(info, described, set())
        flat = np.concatenate([a for part in dicts.values() for a in part.values()], axis=1)
        np.testing.assert_array_equal(flat, obs)
    if described["reward_terms"]:
        assert info["reward_dict"].shape == (NUM_ENVS, len(described["reward_terms"]))
    assert all(info["language_instruction"])


@pytest.mark.parametrize("id", one_id_per_family())
def test_rgb_observations_and_infos(make, id):
    described = engram.describe(id, obs_mode="rgb")
    env = make(id, NUM_ENVS, obs_mode="rgb", privileged=True, language_in_info=True)
    obs, info = env.reset(seed=5)
    keys = ["rgb", "proprio"] + ["task_cue"] * (described["task_cue_dim"] > 0)
    for step in range(3):
        if step > 0:
            obs, *_, info = env.step(env.act("oracle"))
        assert list(obs) == keys
        assert obs["rgb"].shape == (NUM_ENVS, 128, 128, 6)
        assert obs["rgb"].std() > 10
        check_in_space(env, obs)
        check_infos(info, described, set(keys))


@pytest.mark.parametrize("id", one_id_per_family())
def test_depth_and_segmentation(make, id):
    env = make(id, 2, obs_mode="rgb+depth+segmentation")
    obs, _ = env.reset(seed=5)
    cue = ["task_cue"] * (env.description["task_cue_dim"] > 0 and id.startswith("Rotate"))
    assert list(obs) == ["rgb", "proprio", *cue, "depth", "segmentation"]
    for _ in range(3):
        check_in_space(env, obs)
        np.testing.assert_array_equal(obs["depth"] == 0, obs["segmentation"] == 0)
        table = env.description["segmentation_names"].index("table")
        assert (obs["segmentation"] == table).mean() > 0.1
        obs = env.step(env.act("oracle"))[0]


@pytest.mark.parametrize("id", one_id_per_family())
def test_a_single_environment_has_the_infos_of_a_batch(make, id):
    batch = make(id, 1)
    env = engram.make(id)
    try:
        pairs = [(env.reset(seed=5), batch.reset(seed=5))]
        action = env.act("oracle")
        pairs.append((env.step(action)[::4], batch.step(action[np.newaxis])[::4]))
    finally:
        env.close()
    for (obs, info), (batch_obs, batch_info) in pairs:
        assert env.observation_space.contains(obs)
        assert_same(obs, batch_obs[0])
        known = [name for name in batch_info if batch_info.get(f"_{name}", [False])[0]]
        assert list(info) == known
        for name in known:
            np.testing.assert_array_equal(info[name], batch_info[name][0], err_msg=name)
