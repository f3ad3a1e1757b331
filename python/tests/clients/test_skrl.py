"""skrl's wrapper, memory and trainer, as released."""

from __future__ import annotations

import pytest

pytest.importorskip("skrl")

import gymnasium
import torch
from conftest import TASK
from skrl.agents.torch.ppo import PPO, PPO_CFG
from skrl.envs.wrappers.torch import wrap_env
from skrl.memories.torch import RandomMemory
from skrl.trainers.torch import SequentialTrainer
from skrl.utils import set_seed
from skrl.utils.model_instantiators.torch import deterministic_model, gaussian_model
from transitions import assert_transitions

import engram

ENVS, STEPS = 3, 60
NETWORK = [{"name": "net", "input": "OBSERVATIONS", "layers": [16], "activations": "tanh"}]


def batch():
    return gymnasium.make_vec(f"engram/{TASK}", num_envs=ENVS)


@pytest.fixture
def agent(tmp_path):
    set_seed(5)
    env = wrap_env(batch(), verbose=False)
    spaces = {"observation_space": env.observation_space, "action_space": env.action_space}
    models = {
        "policy": gaussian_model(
            **spaces, network=NETWORK, output="ACTIONS", clip_actions=True, device="cpu"
        ),
        "value": deterministic_model(**spaces, network=NETWORK, output="ONE", device="cpu"),
    }
    cfg = PPO_CFG(rollouts=STEPS, learning_epochs=1, mini_batches=1)
    cfg.experiment.directory = str(tmp_path)
    cfg.experiment.write_interval = cfg.experiment.checkpoint_interval = 0
    memory = RandomMemory(memory_size=STEPS, num_envs=ENVS, device="cpu")
    made = PPO(models=models, memory=memory, cfg=cfg, **spaces, device="cpu")
    made.env = env
    yield made
    env.close()


def test_ppo_trains_on_the_transitions_of_engram(agent):
    agent.policy.init_state_dict(role="policy")
    before = [parameter.clone() for parameter in agent.policy.parameters()]
    trainer = SequentialTrainer(
        env=agent.env,
        agents=agent,
        cfg={
            "timesteps": STEPS,
            "disable_progressbar": True,
            "close_environment_at_exit": False,
        },
    )
    trainer.train()
    after = list(agent.policy.parameters())
    assert all(torch.isfinite(parameter).all() for parameter in after)
    assert any(not torch.equal(old, new) for old, new in zip(before, after))
    memory = agent.memory.tensors
    ended = (memory["terminated"] | memory["truncated"]).squeeze(-1)
    assert ended.sum() == ENVS * 2
    assert_transitions(
        TASK,
        obs=memory["observations"],
        actions=memory["actions"],
        rewards=memory["rewards"].squeeze(-1),
        ended=ended,
        seed=5,
    )


def test_wrapped_observations_are_separate(agent):
    observations, _ = agent.env.reset()
    kept = observations.clone()
    later, *_ = agent.env.step(torch.ones(ENVS, 7))
    assert torch.equal(observations, kept)
    assert not torch.equal(later, kept)


def test_images_are_flattened_beside_proprio():
    env = wrap_env(
        engram.make_vec(TASK, ENVS, obs_mode="rgb", image_size=36, threads=1), verbose=False
    )
    observations, _ = env.reset()
    assert observations.shape == (ENVS, 36 * 36 * 6 + 7)
    env.close()
