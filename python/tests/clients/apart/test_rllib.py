"""Ray RLlib, as released: the example that plays engram's batches in its workers."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("ray")

import numpy as np
from conftest import TASK
from ray.rllib.algorithms.ppo import PPOConfig
from ray.rllib.env.single_agent_env_runner import SingleAgentEnvRunner

import engram
from engram.integrations.rllib import RllibVecEnv

WORKERS, ENVS = 4, 32
EXAMPLE = Path(__file__).resolve().parents[3] / "learners/src/engram_learners/rllib_workers.py"


@pytest.mark.parametrize("workers", [1, 2])
def test_rllib_workers_play(workers):
    command = [sys.executable, EXAMPLE, "--iterations=2", "--envs=4", "--episodes=8"]
    done = subprocess.run(
        [*command, f"--workers={workers}"],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "RAY_raylet_start_wait_time_s": "300"},  # for busy machines
    )
    assert done.returncode == 0, done.stderr[-3000:]
    played = [line.split()[:2] for line in done.stdout.splitlines() if "per second" in line]
    assert played == [["1:", "200"], ["2:", "200"]]


def first_observations(environment, seed, **env_config):
    """First observations of the runners of four workers, (128, ...)."""
    config = (
        PPOConfig()
        .environment(environment, env_config={"threads": 1, **env_config})
        .env_runners(
            num_env_runners=WORKERS,
            num_envs_per_env_runner=ENVS,
            gym_env_vectorize_mode="vector_entry_point",
        )
        .debugging(seed=seed)
    )
    rows = []
    for worker in range(1, WORKERS + 1):
        runner = SingleAgentEnvRunner(config=config, worker_index=worker, num_workers=WORKERS)
        episodes = runner.sample(num_timesteps=ENVS, random_actions=True)
        rows += [episode.get_observations(0) for episode in episodes]
        runner.stop()
    return np.array(rows)


@pytest.mark.parametrize("seed", [None, 1])
def test_four_workers_of_thirty_two_play_128_episodes(seed):
    rows = first_observations(RllibVecEnv, seed, id=TASK)
    assert len(rows) == len(np.unique(rows, axis=0)) == WORKERS * ENVS
    again = first_observations(RllibVecEnv, seed, id=TASK)
    assert np.array_equal(rows, again) == (seed is not None)


def test_without_it_rllib_workers_share_episodes():
    rows = first_observations(f"engram:engram/{TASK}", 1)
    assert len(np.unique(rows, axis=0)) == ENVS + WORKERS - 1


def test_a_seed_that_all_workers_share_is_refused():
    with pytest.raises(engram.InvalidArgumentError, match="seed: given in env_config"):
        RllibVecEnv({"id": TASK, "seed": 1})
