from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from conftest import TASK

import engram


def test_an_environment_equals_its_place_in_a_batch(make):
    batch = make(num_envs=3, copy=True)
    batch.reset(seed=10)
    env = engram.make(TASK)
    env.reset(seed=12)
    for _ in range(10):
        actions = batch.act("oracle")
        obs, reward, terminated, truncated, info = env.step(actions[2])
        rows = batch.step(actions)
        np.testing.assert_array_equal(obs, rows[0][2])
        assert (reward, terminated, truncated) == (rows[1][2], rows[2][2], rows[3][2])
        assert info["elapsed_steps"] == rows[4]["elapsed_steps"][2]
    env.close()


def test_results_are_copies():
    env = engram.make(TASK)
    first, _ = env.reset(seed=0)
    kept = first.copy()
    env.step(env.act("random"))
    np.testing.assert_array_equal(first, kept)
    env.close()


def test_snapshots():
    env = engram.make(TASK)
    env.reset(seed=0)
    saved = env.save()
    expected = env.step(env.act())[0]
    env.restore(saved)
    np.testing.assert_array_equal(env.step(env.act())[0], expected)
    env.close()


@pytest.mark.parametrize("duplicate", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_a_pickled_environment_is_made_anew(duplicate):
    env = engram.make(TASK, obs_mode="state_dict")
    other = duplicate(env)
    assert other.observation_space == env.observation_space
    other.reset(seed=0)
    env.close()
    other.close()


@pytest.mark.parametrize("action", [np.zeros((1, 7)), np.zeros(8), None, "x", np.full(7, np.nan)])
def test_bad_actions_are_refused(action):
    env = engram.make(TASK)
    env.reset(seed=0)
    with pytest.raises(engram.InvalidArgumentError):
        env.step(action)
    env.close()


def test_options_of_batches_are_refused():
    with pytest.raises(engram.InvalidArgumentError, match="num_envs"):
        engram.make(TASK, num_envs=2)
