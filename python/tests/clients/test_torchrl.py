"""TorchRL's wrappers and collectors, as released, on engram's batches and single environments."""

from __future__ import annotations

import pytest

pytest.importorskip("torchrl")

import gymnasium
import numpy as np
import torch
from conftest import ENDING_TASK, TASK
from torchrl.collectors import Collector
from torchrl.data import LazyTensorStorage, ReplayBuffer
from torchrl.envs import GymEnv, GymWrapper, check_env_specs
from transitions import assert_transitions

import engram

ENVS, STEPS = 3, 60
MODES = ["SAME_STEP", "DISABLED"]  # those in which TorchRL takes batches


def batch(id: str, mode: str, **options) -> GymWrapper:
    return GymWrapper(engram.make_vec(id, ENVS, autoreset_mode=mode, threads=1, **options))


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("id", [TASK, ENDING_TASK])
def test_a_collector_gathers_the_transitions_of_engram(id, mode):
    env = batch(id, mode)
    env.set_seed(5)
    collector = Collector(env, frames_per_batch=ENVS * STEPS, total_frames=ENVS * STEPS)
    buffer = ReplayBuffer(storage=LazyTensorStorage(STEPS), batch_size=STEPS)
    for data in collector:  # (environments, steps)
        buffer.extend(data.transpose(0, 1).contiguous())
    collector.shutdown()
    kept = buffer[:]
    assert_transitions(
        id,
        obs=kept["observation"],
        actions=kept["action"],
        rewards=kept["next", "reward"].squeeze(-1),
        next_obs=kept["next", "observation"],
        ended=kept["next", "done"].squeeze(-1),
        seed=5,
        resets=2,  # set_seed, and the collector
        autoreset_mode="SAME_STEP",
        resets_when_all_end=mode == "SAME_STEP",
    )


def test_gathered_infos_do_not_reveal_the_answer():
    env = batch(TASK, MODES[0])
    data = env.rollout(3)
    names = {name for key in data.keys(True) for name in (key if isinstance(key, tuple) else [key])}
    assert "success_once" in names
    assert not names & {"oracle_info", "task_cue", "target"}
    env.close()


def test_images_and_proprio():
    env = batch(TASK, MODES[0], obs_mode="rgb", image_size=36)
    data = env.rollout(4)
    assert data["rgb"].shape == (ENVS, 4, 36, 36, 6)
    assert data["rgb"].dtype == torch.uint8
    assert not torch.equal(data["proprio"], data["next", "proprio"])
    env.close()


@pytest.mark.parametrize("id", [TASK, ENDING_TASK])
def test_a_single_environment_by_its_id(id):
    env = GymEnv(f"engram/{id}")
    check_env_specs(env)
    collector = Collector(env, frames_per_batch=STEPS, total_frames=STEPS)
    (data,) = list(collector)
    collector.shutdown()
    assert data["next", "done"].sum() >= 1
    inside = ~data["next", "done"].squeeze(-1)[:-1]
    np.testing.assert_array_equal(
        data["next", "observation"][:-1][inside], data["observation"][1:][inside]
    )
    assert not torch.equal(data["observation"], data["next", "observation"])


def test_a_batch_from_gymnasium_make_vec():
    made = gymnasium.make_vec(f"engram/{TASK}", num_envs=ENVS, autoreset_mode="DISABLED")
    env = GymWrapper(made)
    data = env.rollout(STEPS, break_when_any_done=False)
    assert data["next", "done"].sum() == ENVS * (STEPS // 25)
    env.close()
