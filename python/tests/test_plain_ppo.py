"""python/examples/plain_ppo.py: that it learns through the preset, and its equations."""

from __future__ import annotations

import contextlib
import io
import sys
from types import ModuleType, SimpleNamespace
from unittest import mock

import numpy as np
import pytest
from example_runs import FOLDER, load

pytest.importorskip("jax")

FILE = FOLDER / "plain_ppo.py"


@pytest.fixture(scope="module")
def plain_ppo() -> ModuleType:
    return load("plain_ppo")


def learn(plain_ppo: ModuleType, *words: str) -> float:
    """Success of a run's evaluation, as it prints it."""
    printed = io.StringIO()
    with mock.patch.object(sys, "argv", [str(FILE), *words]), contextlib.redirect_stdout(printed):
        plain_ppo.main()
    return float(printed.getvalue().split("success_once ")[-1].split()[0])


@pytest.mark.parametrize("preset", ["train", "none"])
def test_a_short_run_ends_with_an_evaluation(plain_ppo: ModuleType, preset: str) -> None:
    words = (
        "--total-timesteps=4096",
        "--eval-episodes=50",
        f"--preset={preset}",
        "--without",
        "terms",
    )
    assert 0 <= learn(plain_ppo, *words) <= 1


def test_a_run_with_memory_ends_with_an_evaluation(plain_ppo: ModuleType) -> None:
    words = ("--id=RememberColor3-VLA-v0", "--memory=lstm", "--num-envs=64")
    assert 0 <= learn(plain_ppo, *words, "--total-timesteps=4096", "--eval-episodes=50") <= 1


def test_the_memory_is_an_lstm_that_episodes_reset(plain_ppo: ModuleType) -> None:
    torch = pytest.importorskip("torch")
    rng = np.random.default_rng(1)
    args = SimpleNamespace(memory="lstm", log_std=0.0, forget_bias=0.5)
    params = plain_ppo.init_params(rng, args, 5, 2)
    params["shared"] = []  # the inputs of the shared layer
    weights, recurrent, bias = params["lstm"]
    theirs = torch.nn.LSTM(5, plain_ppo.WIDTH)
    theirs.weight_ih_l0.data, theirs.weight_hh_l0.data, theirs.bias_ih_l0.data = (
        torch.from_numpy(part.T.copy()) for part in (weights, recurrent, bias)
    )
    theirs.bias_hh_l0.data.zero_()
    obs = rng.normal(size=(9, 3, 5)).astype(np.float32)
    begins = np.zeros((9, 3), np.float32)
    begins[4] = 1
    with torch.no_grad():
        parts = [theirs(torch.from_numpy(part))[0].numpy() for part in (obs[:4], obs[4:])]
    expected = np.concatenate([obs, np.concatenate(parts)], -1)
    state = (np.zeros((3, plain_ppo.WIDTH), np.float32),) * 2
    sequence = plain_ppo.remember_all(params, obs, state, begins)
    np.testing.assert_allclose(sequence, expected, atol=1e-5)
    for t in range(9):
        features, state = plain_ppo.remember(params, obs[t], state, begins[t])
        np.testing.assert_allclose(features, expected[t], atol=1e-5)


def test_a_row_names_the_options_that_are_no_defaults(plain_ppo: ModuleType) -> None:
    words = ["--id", "A", "--seed=2", "--memory=lstm", "--vf-coef=2", "--num-envs=64"]
    args = plain_ppo.parse_arguments(words)
    assert plain_ppo.other_options(args) == " --memory lstm --num-envs 64"
    assert args.obs_mode == "objects"  # a default of memories
    assert plain_ppo.other_options(plain_ppo.parse_arguments([])) == ""


@pytest.mark.long
def test_it_learns_through_the_preset(plain_ppo: ModuleType) -> None:
    words = ("--id=ShellGameTouch-VLA-v0", "--total-timesteps=200000")
    assert learn(plain_ppo, *words) >= 0.9


def test_advantages_equal_their_definition(plain_ppo: ModuleType) -> None:
    rng = np.random.default_rng(1)
    rewards, values = rng.random((2, 9, 3)).astype(np.float32)
    dones = (rng.random((10, 3)) < 0.2).astype(np.float32)
    last = rng.random(3).astype(np.float32)
    args = SimpleNamespace(gamma=0.8, gae_lambda=0.7)
    advantages = plain_ppo.estimate_advantages(args, rewards, values, dones[:9], last, dones[9])
    for env in range(3):
        following, value = 0.0, last[env]
        for t in reversed(range(9)):
            alive = 1 - dones[t + 1, env]
            error = rewards[t, env] + 0.8 * value * alive - values[t, env]
            following = error + 0.8 * 0.7 * alive * following
            assert advantages[t, env] == pytest.approx(following, rel=1e-5)
            value = values[t, env]


def test_moments_are_those_of_all_rows(plain_ppo: ModuleType) -> None:
    rng = np.random.default_rng(1)
    parts = [rng.normal(3, 2, (size, 4)) for size in (5, 1, 40)]
    moments = plain_ppo.RunningMoments((4,))
    for rows in parts:
        moments.update(rows)
    whole = np.concatenate(parts)
    np.testing.assert_allclose(moments.mean, whole.mean(0), rtol=1e-4)
    np.testing.assert_allclose(moments.var, whole.var(0), rtol=1e-4)
