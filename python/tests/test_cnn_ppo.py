"""python/examples/cnn_ppo.py: its pictures, and that both critics learn and play."""

from __future__ import annotations

import csv
import sys
from pathlib import Path
from types import ModuleType
from unittest import mock

import numpy as np
import pytest
from example_runs import load

pytest.importorskip("torch")


@pytest.fixture(scope="module")
def cnn_ppo() -> ModuleType:
    return load("cnn_ppo")


def test_pictures_are_means_of_four_pixels(cnn_ppo: ModuleType) -> None:
    frames = np.random.default_rng(1).integers(0, 256, (3, 8, 8, 6)).astype(np.uint8)
    means = frames.reshape(3, 4, 2, 4, 2, 6).astype(float).mean((2, 4))
    np.testing.assert_array_equal(cnn_ppo.halved(frames), np.floor(means))


def test_an_episode_begins_with_no_frame_of_another(cnn_ppo: ModuleType) -> None:
    stack = cnn_ppo.Stack()
    frames = np.zeros((2, 4, 4, 6), np.uint8)
    stack(frames + 10, np.ones(2))
    stacked = stack(frames + 20, np.array([0.0, 1.0]))
    assert stacked.shape == (2, 2, 2, 9)
    assert (stacked[..., :6] == 20).all()
    assert [set(one.ravel()) for one in stacked[..., 6:]] == [{10}, {20}]


@pytest.mark.parametrize("critic", ["state", "rgb"])
def test_a_run_is_a_row(cnn_ppo: ModuleType, tmp_path: Path, critic: str) -> None:
    file = tmp_path / "runs.csv"
    words = ("--total-timesteps=256", "--num-envs=8", "--eval-episodes=50", f"--file={file}")
    with mock.patch.object(sys, "argv", ["cnn_ppo.py", *words, f"--critic={critic}"]):
        cnn_ppo.main()
    with open(file, newline="", encoding="utf-8") as table:
        (row,) = csv.DictReader(table)
    assert row["learner"] == f"cnn_ppo.py --critic {critic} --predict-state 1"
    assert row["env_steps"] == "256"
    assert float(row["success_once"]) <= 0.5  # after one iteration
