"""The package with its modules, for tests: `learners.policy`; and its programs as processes."""

from __future__ import annotations

import importlib
import pkgutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

torch = pytest.importorskip("torch")

import engram_learners as learners  # noqa: E402 (it needs torch)

ROOT = Path(__file__).parents[3]
SOURCE = Path(learners.__file__).parent
RELEASED = ROOT / "python" / "learners" / "released"
TASK = "RememberColor3-VLA-v0"
NEED_MORE = {"engram_learners.rllib_workers", "engram_learners.zoo.popgym"}  # Ray, POPGym

torch.set_num_threads(1)  # as the programs do
for module in pkgutil.walk_packages(learners.__path__, "engram_learners."):
    if module.name not in NEED_MORE:
        importlib.import_module(module.name)


def find_objects(detector: Any) -> None:
    """Makes an untrained detector find some objects, or nothing is tested."""
    with torch.no_grad():
        detector.peak.bias += 4.0
        detector.name.bias[-1] -= 2.0


def run(module: str, *arguments: str) -> list[str]:
    """The lines that a program prints."""
    command = [sys.executable, "-m", f"engram_learners.{module}", *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()
