"""python/examples/library_learners.py: that its learners run, and what a run leaves behind."""

from __future__ import annotations

import csv
import sys
from pathlib import Path
from types import ModuleType
from unittest import mock

import pytest
from example_runs import FOLDER, load

pytest.importorskip("sb3_contrib")

FILE = FOLDER / "library_learners.py"
MODULES = {"sb3": "stable_baselines3", "skrl": "skrl", "torchrl": "torchrl"}


@pytest.fixture(scope="module")
def examples() -> ModuleType:
    return load("library_learners")


def rows_of(examples: ModuleType, file: Path, *words: str) -> list[dict[str, str]]:
    short = ("--total-timesteps=512", "--num-envs=16", "--eval-episodes=50", f"--file={file}")
    with mock.patch.object(sys, "argv", [str(FILE), *short, *words]):
        examples.main()
    with open(file, newline="", encoding="utf-8") as table:
        return list(csv.DictReader(table))


def test_each_run_is_a_row(examples: ModuleType, tmp_path: Path) -> None:
    ids = ["ShellGameTouch-VLA-v0", "FindImposterColor3-VLA-v0"]
    first, second = rows_of(examples, tmp_path / "runs.csv", "--option", "gamma=0.95", "--id", *ids)
    assert [first["id"], second["id"]] == ids
    assert first["learner"] == "sb3-ppo gamma=0.95"
    assert first["env_steps"] == "512"
    assert 0 <= float(first["success_once"]) <= 1
    assert 0 <= float(first["first_answer"]) <= 1


@pytest.mark.parametrize("preset", ["train", "none"])
@pytest.mark.parametrize("learner", ["sb3-sac", "skrl-ppo", "torchrl-ppo"])
def test_learners_play_from_the_state(
    examples: ModuleType, tmp_path: Path, learner: str, preset: str
) -> None:
    pytest.importorskip(MODULES[learner.split("-")[0]])
    words = (f"--learner={learner}", f"--preset={preset}")
    (row,) = rows_of(examples, tmp_path / "runs.csv", *words)
    assert (row["learner"], row["preset"]) == (learner, preset)
    assert float(row["success_once"]) <= 0.5  # after one iteration


def test_the_recurrent_learner_plays_from_objects(examples: ModuleType, tmp_path: Path) -> None:
    words = (
        "--learner=sb3-recurrent-ppo",
        "--id=RememberColor3-VLA-v0",
        "--obs-mode=objects",
        "--option=n_epochs=1",
    )
    (row,) = rows_of(examples, tmp_path / "runs.csv", *words)
    assert row["learner"] == "sb3-recurrent-ppo n_epochs=1"
    assert float(row["success_once"]) <= 0.5
