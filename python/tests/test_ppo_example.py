"""python/examples/ppo.py: its parts against plain references, and that it runs and learns."""

from __future__ import annotations

import math
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from example_runs import learn, load

import engram

torch = pytest.importorskip("torch")
pytest.importorskip("matplotlib")


@pytest.fixture(scope="module")
def ppo() -> ModuleType:
    return load("ppo")


def test_moments_equal_those_of_all_rows_at_once(ppo: ModuleType) -> None:
    rows = np.random.default_rng(0).normal(5.0, [0.1, 1.0, 300.0], (1000, 3))
    moments = ppo.Moments(3)
    for part in np.split(rows, [1, 10, 400]):
        moments.update(torch.tensor(part))
    np.testing.assert_allclose(moments.mean, rows.mean(0), rtol=1e-10)
    np.testing.assert_allclose(moments.var, rows.var(0), rtol=1e-10)


def test_advantages_equal_their_definition(ppo: ModuleType) -> None:
    """The sum of decayed errors up to the end of the episode, written out."""
    generator = np.random.default_rng(1)
    errors = generator.normal(size=(12, 3)).astype(np.float32)
    ended = generator.random((12, 3)) < 0.2
    got = ppo.estimate_advantages(torch.tensor(errors), torch.tensor(ended), 0.7)
    for env in range(3):
        for t in range(12):
            expected, weight = 0.0, 1.0
            for k in range(t, 12):
                expected += weight * errors[k, env]
                weight *= 0.7
                if ended[k, env]:
                    break
            assert float(got[t, env]) == pytest.approx(expected, abs=1e-5)


def test_a_rollout_links_each_observation_to_its_true_successor(ppo: ModuleType) -> None:
    """Episodes of 25 steps: the 25th leads to the episode's last observation, not to a new one."""
    env = engram.make_vec("RememberColor3-VLA-v0", num_envs=4, autoreset_mode="SAME_STEP")
    agent = ppo.Agent(env, SimpleNamespace(width=8, log_std=-1.0))
    torch.manual_seed(0)
    rollout = ppo.Collector(env, 5).collect(agent, 60)
    assert rollout.observations.shape == (60, 4, 35)
    assert [t for t in range(60) if rollout.ended[t].all()] == [24, 49]
    assert not rollout.terminated.any()  # these episodes end by truncation alone
    within = ~rollout.ended[:-1]
    successors = rollout.observations[1:]
    assert torch.equal(rollout.next_observations[:-1][within], successors[within])
    # The first episode is that of environments which are never reset automatically.
    plain = engram.make_vec("RememberColor3-VLA-v0", num_envs=4, autoreset_mode="DISABLED")
    observation, _ = plain.reset(seed=5)
    for t in range(25):
        np.testing.assert_array_equal(rollout.observations[t], observation)
        observation, reward, *_ = plain.step(rollout.actions[t].clamp(-1.0, 1.0).numpy())
        np.testing.assert_array_equal(rollout.rewards[t], reward)
    np.testing.assert_array_equal(rollout.next_observations[24], observation)
    assert not torch.equal(rollout.next_observations[24], rollout.observations[25])


def test_it_runs_and_leaves_its_files(tmp_path: Path) -> None:
    budget = ["--steps", "4000", "--num-envs", "32", "--eval-every", "2", "--eval-episodes", "8"]
    output, rows = learn("ppo", tmp_path / "new" / "folder", *budget)
    assert "8 fresh episodes" in output
    assert [row["steps"] for row in rows] == [800.0 * i for i in range(1, 6)]
    for row in rows:
        assert all(math.isfinite(row[key]) for key in ("policy_loss", "value_loss", "kl", "return"))
    assert [not math.isnan(row["eval_success_once"]) for row in rows] == [False, True] * 2 + [False]
    picture = (tmp_path / "new" / "folder" / "curve.png").read_bytes()
    assert picture.startswith(b"\x89PNG")
    assert len(picture) > 5000
    weights = torch.load(tmp_path / "new" / "folder" / "agent.pt", weights_only=True)
    assert all(torch.isfinite(value).all() for value in weights.values())


def test_the_same_seed_learns_the_same(tmp_path: Path) -> None:
    budget = ["--steps", "2400", "--num-envs", "16", "--eval-episodes", "4"]
    _, one = learn("ppo", tmp_path / "one", *budget, "--threads", "1")
    _, two = learn("ppo", tmp_path / "two", *budget, "--threads", "2")
    _, other = learn("ppo", tmp_path / "other", *budget, "--seed", "2")
    assert [row["policy_loss"] for row in one] == [row["policy_loss"] for row in two]
    assert [row["policy_loss"] for row in one] != [row["policy_loss"] for row in other]


def test_it_learns_to_approach(tmp_path: Path) -> None:
    """A sixth of the budget of a full run: arms that move towards the target double the return.

    Seeds 1, 2 and 3 end at 2.6, 2.7 and 1.9 times the first returns.
    """
    _, rows = learn(
        "ppo", tmp_path, "--steps", "100000", "--eval-every", "100", "--eval-episodes", "8"
    )
    returns = [row["return"] for row in rows]
    assert np.mean(returns[-5:]) > 1.5 * np.mean(returns[:5])
