"""Tianshou's vector environments, collector and buffer, as released."""

from __future__ import annotations

import pytest

pytest.importorskip("tianshou")

import gymnasium
import numpy as np
from conftest import ENDING_TASK, TASK
from tianshou.algorithm.algorithm_base import RandomActionPolicy
from tianshou.data import Collector, VectorReplayBuffer
from tianshou.env import DummyVectorEnv, ShmemVectorEnv
from transitions import assert_transitions

ENVS, STEPS = 3, 60


def single(id: str):
    return lambda: gymnasium.make(f"engram/{id}", threads=1)


@pytest.mark.parametrize("id", [TASK, ENDING_TASK])
@pytest.mark.parametrize("kind", [DummyVectorEnv, ShmemVectorEnv])
def test_a_collector_gathers_the_transitions_of_engram(kind, id):
    envs = kind([single(id) for _ in range(ENVS)])
    buffer = VectorReplayBuffer(ENVS * STEPS, ENVS)
    collector = Collector(RandomActionPolicy(envs.action_space[0]), envs, buffer)
    envs.seed(5)
    collector.reset()
    assert collector.collect(n_step=ENVS * STEPS).n_collected_steps == ENVS * STEPS

    def rows(values):  # environments are one behind the other
        return np.asarray(values).reshape(ENVS, STEPS, -1).swapaxes(0, 1)

    assert_transitions(
        id,
        obs=rows(buffer.obs),
        actions=rows(buffer.act),
        rewards=rows(buffer.rew)[..., 0].astype(np.float32),
        next_obs=rows(buffer.obs_next),
        ended=rows(buffer.done)[..., 0],
        seed=5,
        resets=2,  # seed and reset
        autoreset_mode="SAME_STEP",
    )
    envs.close()
