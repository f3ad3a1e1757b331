"""Parts of python/examples/mikasa_ppo.py; test_original_scripts.py runs the whole."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

pytest.importorskip("torch")

import torch

import engram.mikasa as mikasa

EXAMPLE = Path(__file__).parents[2] / "examples" / "mikasa_ppo.py"
ID = "RememberColor3-VLA-v0"


@pytest.fixture(scope="module")
def ppo():
    spec = importlib.util.spec_from_file_location("mikasa_ppo", EXAMPLE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def envs(ppo):
    made = ppo.make_envs(ID, 8)
    yield made
    made.close()


def test_the_scale_is_folded_into_the_policy(ppo, envs):
    torch.manual_seed(0)
    rows = torch.rand(500, 35) * torch.linspace(0.1, 5, 35) + 3
    rows[:, 4] = 7.0  # constant values are not amplified
    scale = ppo.Scale(35)
    for part in rows.split(99):
        scale.update(part)
    torch.testing.assert_close(scale.mean.float(), rows.mean(0))
    torch.testing.assert_close(scale.spread()[0].float(), rows[:, 0].std(unbiased=False))
    agent = mikasa.AgentStateOnly(envs)
    before = agent.get_action({"state": scale(rows)}, True), agent.get_value({"state": scale(rows)})
    scale.fold_into(agent)
    after = agent.get_action({"state": rows}, True), agent.get_value({"state": rows})
    for one, other in zip(before, after):
        torch.testing.assert_close(one, other, atol=1e-4, rtol=1e-4)


def test_an_episode_of_all_environments(ppo, envs):
    """Frozen steps are left out; returns without a critic are sums of discounted rewards."""
    agent = mikasa.AgentStateOnly(envs)
    with torch.no_grad():
        agent.critic[-1].weight.zero_()
    scale = ppo.Scale(35)
    envs.reset(seed=5)
    success, inputs, actions, logps, advantages, returns = ppo.play(envs, agent, scale, 0.5, 1.0)
    assert 0 <= success <= 1
    free = len(returns)
    assert 8 * (25 - 10) <= free < 8 * 25
    assert inputs.shape == (free, 35)
    assert actions.shape == (free, 7)
    assert len(logps) == free
    assert torch.equal(advantages, returns)
    assert returns.abs().max() < 2
    assert returns.std() > 0
    assert scale.count == 8 * 25
