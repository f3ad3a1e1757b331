from __future__ import annotations

import copy
import pickle

import gymnasium
import numpy as np
import pytest
from conftest import TASK

import engram


def test_an_environment_equals_its_place_in_a_batch(make):
    batch = make(num_envs=3)
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
    assert repr(other) == repr(env)
    other.reset(seed=0)
    env.close()
    other.close()


@pytest.mark.parametrize("duplicate", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_a_duplicate_keeps_its_specification(duplicate):
    env = gymnasium.make(f"engram/{TASK}", reward_mode="sparse")
    other = duplicate(env)
    assert other.spec == env.spec
    assert other.unwrapped.spec == env.unwrapped.spec
    assert other.spec.kwargs["reward_mode"] == "sparse"
    env.close()
    other.close()


def test_the_specification_makes_the_same_environment():
    env = engram.make(f"engram/{TASK}", obs_mode="objects", seed=3, render_mode="rgb_array")
    assert env.spec.id == f"engram/{TASK}"
    other = gymnasium.make(env.spec)
    np.testing.assert_array_equal(other.reset()[0], env.reset()[0])
    assert other.render_mode == "rgb_array"
    assert other.spec.max_episode_steps == 25
    env.close()
    other.close()


def test_infos_do_not_reveal_the_answer():
    env = engram.make(TASK)
    _, info = env.reset(seed=0)
    assert {"oracle_info", "reward_dict", "language_instruction"}.isdisjoint(info)
    assert env.language_instruction.startswith("Observe")
    env.close()
    env = engram.make(TASK, privileged=True, language_in_info=True)
    _, info = env.reset(seed=0)
    assert {"oracle_info", "language_instruction"} <= set(info)
    env.close()


def test_an_ended_episode_is_not_stepped():
    env = engram.make(TASK)
    env.reset(seed=0)
    truncated = False
    while not truncated:
        *_, truncated, _ = env.step(env.act("zero"))
    saved = env.save()
    with pytest.raises(engram.BadStateError, match="ended; reset first"):
        env.step(env.act("zero"))
    assert env.save() == saved
    env.reset()
    env.step(env.act("zero"))
    env.close()


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
