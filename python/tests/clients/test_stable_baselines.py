"""Stable-Baselines3 and sb3-contrib, as released: buffers, checkers, and networks that remember."""

from __future__ import annotations

import pytest

pytest.importorskip("sb3_contrib")

import numpy as np
import torch
from conftest import ENDING_TASK, TASK
from sb3_contrib import RecurrentPPO
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.env_checker import check_env
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.vec_env import VecMonitor
from transitions import assert_transitions

import engram
from engram.integrations.sb3 import Sb3VecEnv

ENVS, STEPS = 3, 60


@pytest.mark.parametrize("id", [TASK, ENDING_TASK])
def test_a_replay_buffer_holds_the_transitions_of_engram(id):
    env = Sb3VecEnv(id, num_envs=ENVS, threads=1)
    env.seed(5)
    model = SAC("MlpPolicy", env, buffer_size=ENVS * STEPS, learning_starts=10**6, device="cpu")
    model.learn(ENVS * STEPS)
    kept = model.replay_buffer
    assert_transitions(
        id,
        obs=kept.observations,
        actions=kept.actions,
        rewards=kept.rewards,
        next_obs=kept.next_observations,
        ended=kept.dones.astype(bool),
        seed=5,
        autoreset_mode="SAME_STEP",
    )
    env.close()


# Sb3VecEnv is faster; make_vec_env makes single environments by their id.
def test_vector_environments_of_gymnasium():
    env = make_vec_env(f"engram/{TASK}", n_envs=2, seed=5)
    model = PPO("MlpPolicy", env, n_steps=50, batch_size=50, n_epochs=1, device="cpu")
    model.learn(100)
    assert [info["l"] for info in model.ep_info_buffer] == [25] * 4
    returns, lengths = evaluate_policy(model, env, 3, return_episode_rewards=True, warn=False)
    assert lengths == [25] * 3
    assert len(set(returns)) == 3
    env.close()


@pytest.mark.parametrize("obs_mode", ["state", "rgb", "objects"])
@pytest.mark.filterwarnings("ignore")
def test_its_checker_accepts_the_single_environment(obs_mode):
    env = engram.make(TASK, obs_mode=obs_mode)
    check_env(env, skip_render_check=True)
    env.close()


@pytest.mark.parametrize(
    ("policy", "options"),
    [
        ("MlpLstmPolicy", {"obs_mode": "objects"}),
        ("MultiInputLstmPolicy", {"obs_mode": "rgb", "image_size": 36}),
    ],
)
@pytest.mark.filterwarnings("ignore:It seems that your observation space")
def test_recurrent_ppo_trains(policy, options):
    env = VecMonitor(Sb3VecEnv(TASK, num_envs=2, threads=1, **options))
    model = RecurrentPPO(policy, env, n_steps=50, batch_size=50, n_epochs=1, device="cpu", seed=5)
    before = [parameter.detach().clone() for parameter in model.policy.parameters()]
    model.learn(100)
    assert len(model.ep_info_buffer) == 4
    after = list(model.policy.parameters())
    assert all(torch.isfinite(parameter).all() for parameter in after)
    assert any(not torch.equal(old, new) for old, new in zip(before, after))
    # Hidden states begin anew with each episode, as the buffer's marks say.
    starts = model.rollout_buffer.episode_starts.reshape(50, 2)
    assert np.flatnonzero(starts[:, 0]).tolist() == [0, 25]
    env.close()
