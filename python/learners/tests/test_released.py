"""engram_learners/released: policies from pictures, played by engram as they are."""

from __future__ import annotations

import json
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from programs import RELEASED

FOLDERS = sorted(RELEASED.iterdir())
SMALL = 400_000  # bytes


def test_there_are_ten() -> None:
    assert len(FOLDERS) >= 10


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: folder.name)
def test_it_has_its_scores(folder: Path) -> None:
    result = json.loads((folder / "result.json").read_text())
    assert result["id"] == folder.name
    assert result["learner"] == "distilled from rgb"
    assert result["success_once"] >= 0.9
    assert result["wiped"]["success_once"] <= result["success_once"]
    assert (folder / "agent.pt").stat().st_size < SMALL


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: folder.name)
def test_eval_plays_it(folder: Path) -> None:
    policy = shlex.join([sys.executable, "-m", "engram_learners.serve", str(folder / "agent.pt")])
    words = [
        "--episodes",
        "10",
        "--seed",
        "3000000",
        "--threads",
        "1",
        "--num-envs",
        "10",
        "--json",
    ]
    command = [sys.executable, "-m", "engram", "eval", folder.name, "--obs", "rgb"]
    done = subprocess.run(
        [*command, "--policy-command", policy, *words], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    [task] = json.loads(done.stdout)["tasks"]
    assert task["sr"] >= 0.8
