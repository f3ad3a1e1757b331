"""Gymnasium's checkers and its wrappers of single environments, of whichever version there is."""

from __future__ import annotations

import warnings

import gymnasium
import numpy as np
import pytest
from conftest import TASK
from gymnasium import wrappers
from gymnasium.utils.env_checker import check_env

import engram
from engram.envs.compat import GYMNASIUM_1


def rescaled(env):
    return wrappers.RescaleAction(env, np.float32(-2), np.float32(2))


def stacked(env):
    return wrappers.FrameStackObservation(env, 3) if GYMNASIUM_1 else wrappers.FrameStack(env, 3)


def time_aware(env):
    if GYMNASIUM_1:
        return wrappers.TimeAwareObservation(env)
    return wrappers.TimeAwareObservation(wrappers.FlattenObservation(env))


def doubled(env):
    if GYMNASIUM_1:
        return wrappers.TransformObservation(env, lambda obs: 2 * obs, env.observation_space)
    return wrappers.TransformObservation(env, lambda obs: 2 * obs)


def reset_by_itself(env):
    return wrappers.Autoreset(env) if GYMNASIUM_1 else wrappers.AutoResetWrapper(env)


SINGLE = [
    wrappers.ClipAction,
    wrappers.FlattenObservation,
    wrappers.NormalizeObservation,
    wrappers.NormalizeReward,
    wrappers.RecordEpisodeStatistics,
    doubled,
    rescaled,
    reset_by_itself,
    stacked,
    time_aware,
]


def fits(env, obs) -> bool:
    if not GYMNASIUM_1:  # its wrappers make float64 of what they call float32
        obs = np.asarray(obs, env.observation_space.dtype)
    return env.observation_space.contains(obs)


@pytest.mark.parametrize("wrapper", SINGLE, ids=lambda wrapper: wrapper.__name__)
def test_wrappers_of_single_environments(wrapper):
    env = wrapper(gymnasium.make(f"engram/{TASK}"))
    obs, _ = env.reset(seed=1)
    assert fits(env, obs)
    kept, seen = np.array(obs), []
    for _ in range(25):
        obs, reward, terminated, truncated, info = env.step(env.action_space.sample())
        assert fits(env, obs)
        seen.append(np.array(obs))
    assert np.isfinite(reward)
    assert truncated
    assert not terminated
    assert len({obs.tobytes() for obs in [kept, *seen]}) == 26  # each is of its own step
    if wrapper is wrappers.RecordEpisodeStatistics:
        assert info["episode"]["l"] == 25
    env.close()


def test_a_film(tmp_path):
    pytest.importorskip("moviepy")
    env = gymnasium.make(f"engram/{TASK}", render_mode="rgb_array", render_size=32)
    env = wrappers.RecordVideo(env, str(tmp_path), disable_logger=True)
    env.reset(seed=1)
    for _ in range(25):
        env.step(env.action_space.sample())
    env.close()
    (video,) = tmp_path.glob("*.mp4")
    assert video.stat().st_size > 500


@pytest.mark.parametrize("obs_mode", ["state", "state_dict", "rgb", "objects", "objects_dict"])
def test_the_passive_checker_has_no_warnings(obs_mode):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = gymnasium.make(f"engram/{TASK}", obs_mode=obs_mode)
        env.reset(seed=1)
        for _ in range(25):
            *_, truncated, _ = env.step(env.action_space.sample())
        assert truncated
        env.close()


def test_the_checker_draws_it_too():
    env = gymnasium.make(f"engram/{TASK}", render_mode="rgb_array", render_size=32)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*gym.make.*|.*spec.*|.*deepcopy.*")
        check_env(env.unwrapped)
    env.close()


def test_a_loop_that_keeps_its_observations():
    env = engram.make_vec(TASK, 3)
    obs, _ = env.reset(seed=1)
    kept = []
    for _ in range(10):
        action = env.act("random")
        next_obs, reward, *_ = env.step(action)
        kept.append((obs, reward, next_obs))
        obs = next_obs
    rows = [pair[0].tobytes() for pair in kept]
    assert len(set(rows)) == 10
    assert [pair[2].tobytes() for pair in kept[:-1]] == rows[1:]
    env.close()
