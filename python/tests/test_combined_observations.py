"""Observation modes with images and a row of numbers: equal to those of each by itself."""

from __future__ import annotations

import gymnasium
import numpy as np
import pytest
from conftest import TASK
from transitions import end_of_episode

import engram

MAPS = ["rgb", "rgb+depth", "rgb+segmentation", "rgb+depth+segmentation"]


@pytest.mark.parametrize("row", ["state", "objects"])
@pytest.mark.parametrize("images", MAPS)
def test_each_part_is_as_by_itself(make, images, row):
    envs = [make(obs_mode=mode, num_envs=2) for mode in (f"{images}+{row}", images, row)]
    both, pictures, numbers = (env.reset(seed=4)[0] for env in envs)
    for _ in range(4):
        assert list(both) == [*pictures, row]
        assert list(envs[0].single_observation_space) == list(both)
        assert envs[0].observation_space.contains(both)
        for name, value in pictures.items():
            np.testing.assert_array_equal(both[name], value)
        np.testing.assert_array_equal(both[row], numbers)
        actions = envs[1].act("oracle")
        both, pictures, numbers = (env.step(actions)[0] for env in envs)
    assert envs[0].single_observation_space[row] == envs[2].single_observation_space
    assert envs[0].description["state_fields"] == envs[2].description["state_fields"]


def test_a_single_environment_and_gymnasium_have_them():
    for env in (
        engram.make(TASK, obs_mode="rgb+state", seed=0),
        gymnasium.make(f"engram/{TASK}", obs_mode="rgb+state", seed=0),
    ):
        obs, _ = env.reset(seed=3)
        assert env.observation_space.contains(obs)
        assert obs["state"].shape == engram.make(TASK, seed=0).observation_space.shape
        env.close()


def test_the_last_observation_of_an_episode_has_both(make):
    env = make(obs_mode="rgb+objects", num_envs=1, autoreset_mode="SAME_STEP")
    twin = make(obs_mode="rgb+objects", num_envs=1, autoreset_mode="DISABLED")
    final, last, _ = end_of_episode(env, twin)
    for name in ("rgb", "objects"):
        np.testing.assert_array_equal(final[name], last[name][0])


def test_arrays_of_the_caller_take_both(make):
    width = make(num_envs=2).reset()[0].shape[1]
    out = {
        "rgb": np.zeros((2, 128, 128, 6), np.uint8),
        "observation": np.zeros((2, width), np.float32),
    }
    env = make(obs_mode="rgb+state", num_envs=2, out=out)
    obs, _ = env.reset(seed=1)
    assert obs["rgb"] is out["rgb"]
    assert obs["state"] is out["observation"]
    np.testing.assert_array_equal(obs["state"], make(num_envs=2).reset(seed=1)[0])


def test_several_tasks_have_common_rows(make):
    tasks = ["RememberColor3-VLA-v0", "RotateLenientPos-VLA-v0"]
    both, _ = make(tasks, obs_mode="rgb+state", num_envs=2).reset(seed=5)
    numbers, _ = make(tasks, obs_mode="state", num_envs=2).reset(seed=5)
    np.testing.assert_array_equal(both["state"], numbers)
    assert list(both) == ["rgb", "proprio", "task_cue", "state"]


def test_integrations_have_both():
    sb3 = pytest.importorskip("engram.integrations.sb3")
    torchrl = pytest.importorskip("torchrl.envs")
    expected, _ = engram.make(TASK, obs_mode="rgb+state").reset(seed=3)
    env = sb3.Sb3VecEnv(TASK, 1, obs_mode="rgb+state")
    env.seed(3)
    for name, values in env.reset().items():
        np.testing.assert_array_equal(values[0], expected[name])
    seen = torchrl.GymEnv(f"engram/{TASK}", obs_mode="rgb+state").reset(seed=3)
    np.testing.assert_array_equal(seen["pixels" if "pixels" in seen else "rgb"], expected["rgb"])
    # TorchRL's name of a state.
    np.testing.assert_array_equal(seen["observation"], expected["state"])
