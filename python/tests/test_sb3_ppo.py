"""python/examples/sb3_ppo.py: that its learners run, and what a run leaves behind."""

from __future__ import annotations

import csv
import sys
from pathlib import Path
from types import ModuleType
from unittest import mock

import pytest
from example_runs import FOLDER, load

pytest.importorskip("sb3_contrib")

FILE = FOLDER / "sb3_ppo.py"


@pytest.fixture(scope="module")
def sb3_ppo() -> ModuleType:
    return load("sb3_ppo")


def rows_of(sb3_ppo: ModuleType, file: Path, *words: str) -> list[dict[str, str]]:
    short = ("--total-timesteps=512", "--num-envs=16", "--eval-episodes=50", f"--file={file}")
    with mock.patch.object(sys, "argv", [str(FILE), *short, *words]):
        sb3_ppo.main()
    with open(file, newline="", encoding="utf-8") as table:
        return list(csv.DictReader(table))


def test_each_run_is_a_row(sb3_ppo: ModuleType, tmp_path: Path) -> None:
    ids = ["ShellGameTouch-VLA-v0", "FindImposterColor3-VLA-v0"]
    first, second = rows_of(sb3_ppo, tmp_path / "runs.csv", "--option", "gamma=0.95", "--id", *ids)
    assert [first["id"], second["id"]] == ids
    assert first["learner"] == "PPO of Stable-Baselines3 gamma=0.95"
    assert first["env_steps"] == "512"
    assert 0 <= float(first["success_once"]) <= 1
    assert 0 <= float(first["first_answer"]) <= 1


def test_the_recurrent_learner_plays_from_objects(sb3_ppo: ModuleType, tmp_path: Path) -> None:
    words = (
        "--id=RememberColor3-VLA-v0",
        "--obs-mode=objects",
        "--recurrent",
        "--option=n_epochs=1",
    )
    (row,) = rows_of(sb3_ppo, tmp_path / "runs.csv", *words)
    assert row["learner"] == "RecurrentPPO of sb3-contrib n_epochs=1"
    assert float(row["success_once"]) <= 0.5  # after one iteration
