"""PufferLib, as released (pufferlib-core): native and emulated environments, and its trainer."""

from __future__ import annotations

import pytest

pytest.importorskip("pufferlib")

import gymnasium
import numpy as np
import pufferlib.emulation
import pufferlib.models
import pufferlib.vector
import torch
from conftest import ENDING_TASK, TASK
from doc_blocks import groups
from pufferlib import pufferl
from transitions import assert_transitions

import engram
from engram.integrations.pufferlib import PufferVecEnv

ENVS, STEPS, SEED = 3, 60, 5


def played(vecenv, steps: int = STEPS):
    """What PufferLib's loop sees of random actions, (steps, environments, ...), and infos."""
    rng = np.random.default_rng(1)
    obs, _ = vecenv.reset(seed=SEED)
    seen = {"obs": [], "actions": [], "rewards": [], "ended": []}
    infos = []
    for _ in range(steps):
        action = rng.uniform(-1, 1, (len(obs), 7)).astype(np.float32)
        seen["obs"].append(np.array(obs))
        seen["actions"].append(action)
        obs, rewards, terminals, truncations, info = vecenv.step(action)
        seen["rewards"].append(np.array(rewards))
        seen["ended"].append(np.array(terminals) | np.array(truncations))
        infos += info
    vecenv.close()
    return {name: np.array(values) for name, values in seen.items()}, infos


@pytest.mark.parametrize("obs_mode", ["state", "objects"])
@pytest.mark.parametrize("id", [TASK, ENDING_TASK])
def test_a_native_batch_has_the_transitions_of_engram(id, obs_mode):
    options = {"id": id, "num_envs": ENVS, "obs_mode": obs_mode, "threads": 1}
    seen, infos = played(pufferlib.vector.make(PufferVecEnv, env_kwargs=options))
    assert_transitions(id, **seen, seed=SEED * ENVS, obs_mode=obs_mode, autoreset_mode="SAME_STEP")
    assert len(infos) == seen["ended"].any(1).sum() > 0
    for info in infos:
        assert set(info) == {"episode_return", "episode_length", "success_once"}
        assert 1 <= info["episode_length"] <= engram.describe(id)["horizon"]


def test_workers_play_different_episodes():
    seen, _ = played(
        pufferlib.vector.make(
            PufferVecEnv,
            env_kwargs={"id": TASK, "num_envs": ENVS, "threads": 1},
            backend=pufferlib.vector.Multiprocessing,
            num_envs=2,
            num_workers=2,
        ),
        steps=30,
    )
    assert_transitions(TASK, **seen, seed=SEED * ENVS, autoreset_mode="SAME_STEP")


def test_four_workers_of_thirty_two_play_128_episodes():
    vecenv = pufferlib.vector.make(
        PufferVecEnv,
        env_kwargs={"id": TASK, "num_envs": 32, "threads": 1},
        backend=pufferlib.vector.Multiprocessing,
        num_envs=4,
        num_workers=4,
        overwork=True,  # more than this machine has cores
    )
    obs, _ = vecenv.reset(seed=SEED)
    assert len(obs) == len(np.unique(obs, axis=0)) == 128
    vecenv.close()


def emulated(buf=None, seed=0, **options):
    env = gymnasium.make(f"engram/{TASK}", threads=1, **options)
    return pufferlib.emulation.GymnasiumPufferEnv(env=env, buf=buf, seed=seed)


def serial(num_envs: int, **options):
    backend = pufferlib.vector.Serial
    return pufferlib.vector.make(emulated, env_kwargs=options, num_envs=num_envs, backend=backend)


def test_single_environments_are_emulated():
    seen, _ = played(serial(ENVS), steps=20)
    assert_transitions(TASK, **seen, seed=SEED)


def test_pictures_are_emulated():
    vecenv = serial(2, obs_mode="rgb")
    obs, _ = vecenv.reset(seed=SEED)
    kind = vecenv.driver_env.emulated["emulated_observation_dtype"]
    parts = np.asarray(obs).view(kind)
    batch = engram.make_vec(TASK, 2, obs_mode="rgb", threads=1)
    expected, _ = batch.reset(seed=SEED)
    for name in ("rgb", "proprio"):
        np.testing.assert_array_equal(parts[name].reshape(expected[name].shape), expected[name])
    vecenv.close()


def test_observations_of_several_arrays_are_refused():
    with pytest.raises(engram.InvalidArgumentError, match="'rgb' given; 'state', 'objects'"):
        PufferVecEnv(TASK, obs_mode="rgb")
    with pytest.raises(TypeError, match="Did you mean 'num_envs'"):
        PufferVecEnv(TASK, num_env=2)


CONFIG = {
    "seed": 1, "torch_deterministic": True, "device": "cpu", "cpu_offload": False, "compile": False,
    "optimizer": "adam", "learning_rate": 0.003, "adam_beta1": 0.9, "adam_beta2": 0.999,
    "adam_eps": 1e-8, "anneal_lr": False, "precision": "float32", "total_timesteps": 1200,
    "bptt_horizon": 25, "batch_size": 400, "minibatch_size": 200, "max_minibatch_size": 200,
    "update_epochs": 2, "gamma": 0.9, "gae_lambda": 0.95, "vtrace_rho_clip": 1, "vtrace_c_clip": 1,
    "prio_alpha": 0.8, "prio_beta0": 0.2, "clip_coef": 0.2, "vf_clip_coef": 0.2, "vf_coef": 2,
    "ent_coef": 0.001, "max_grad_norm": 1.5, "checkpoint_interval": 100,
}  # fmt: skip


@pytest.mark.parametrize("recurrent", [False, True])
def test_its_trainer_learns_from_a_native_batch(recurrent, tmp_path):
    torch.manual_seed(1)
    vecenv = pufferlib.vector.make(
        PufferVecEnv, env_kwargs={"id": TASK, "num_envs": 16, "obs_mode": "objects"}
    )
    policy = pufferlib.models.Default(vecenv, hidden_size=32)
    if recurrent:
        policy = pufferlib.models.LSTMWrapper(vecenv, policy, input_size=32, hidden_size=32)
    config = {**CONFIG, "use_rnn": recurrent, "env": TASK, "data_dir": str(tmp_path)}
    before = [parameter.detach().clone() for parameter in policy.parameters()]
    trainer = pufferl.PuffeRL(config, vecenv, policy)
    try:
        for _ in range(3):  # episodes are reported when the next one has begun
            stats = dict(trainer.evaluate())
            trainer.train()
            trainer.stats.clear()
    finally:
        trainer.close()
    assert stats["episode_length"] == [25.0]  # of all environments at once
    assert 0 <= stats["success_once"][0] <= 1
    after = list(policy.parameters())
    assert all(torch.isfinite(parameter).all() for parameter in after)
    assert any(not torch.equal(old, new) for old, new in zip(before, after))


def test_the_block_of_its_page_runs(tmp_path):
    blocks = [block for group in groups() for block in group if block.elsewhere == "pufferlib"]
    assert len(blocks) == 1
    assert "episode_return" in blocks[0].run(tmp_path)
