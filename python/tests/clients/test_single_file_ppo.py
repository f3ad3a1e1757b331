"""A learner of one file, as people write them, on all of Gymnasium's ways to many environments."""

from __future__ import annotations

import pytest

pytest.importorskip("torch")

import gymnasium
from conftest import TASK
from single_file_ppo import train
from transitions import assert_transitions

from engram.envs.compat import GYMNASIUM_1

ENVS = 16


def by_make_vec(num_envs: int):
    if not GYMNASIUM_1:
        made = gymnasium.make_vec(f"engram/{TASK}", num_envs=num_envs, vectorization_mode="custom")
        return gymnasium.wrappers.RecordEpisodeStatistics(made)
    made = gymnasium.make_vec(f"engram/{TASK}", num_envs=num_envs)
    return gymnasium.wrappers.vector.RecordEpisodeStatistics(made)


def of_single_ones(num_envs: int):
    def make_env():
        return gymnasium.make(f"engram/{TASK}")

    made = gymnasium.vector.SyncVectorEnv([make_env for _ in range(num_envs)])
    if not GYMNASIUM_1:
        return gymnasium.wrappers.RecordEpisodeStatistics(made)
    return gymnasium.wrappers.vector.RecordEpisodeStatistics(made)


@pytest.mark.parametrize("make_envs", [by_make_vec, of_single_ones])
def test_it_stores_the_transitions_of_engram(make_envs):
    envs = make_envs(ENVS)
    stored = train(envs, steps=60, seed=7)
    assert_transitions(
        TASK,
        obs=stored["obs"],
        actions=stored["actions"],
        rewards=stored["rewards"],
        seed=7,
    )
    assert len(stored["episodes"]) == 2 * ENVS
    assert stored["losses"] == pytest.approx(stored["losses"])  # no NaN
    envs.close()
