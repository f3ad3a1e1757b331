"""The package with its modules, for tests: `learners.policy`; and its programs."""

from __future__ import annotations

import contextlib
import importlib
import io
import pkgutil
import runpy
import sys
import warnings
from pathlib import Path
from typing import Any
from unittest import mock

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
    """The lines that `python -m` prints. In this process: another one would import torch again."""
    printed = io.StringIO()
    with (
        mock.patch.object(sys, "argv", ["", *arguments]),
        contextlib.redirect_stdout(printed),
        warnings.catch_warnings(),
    ):
        warnings.simplefilter("ignore", RuntimeWarning)  # its module is imported already
        try:
            runpy.run_module(f"engram_learners.{module}", run_name="__main__", alter_sys=True)
        except SystemExit as end:
            if end.code:
                raise
    return printed.getvalue().splitlines()


def refused(module: str, *arguments: str) -> tuple[int, str]:
    """Exit code of a program that refuses its arguments, and what it says."""
    said = io.StringIO()
    with contextlib.redirect_stderr(said), pytest.raises(SystemExit) as end:
        run(module, *arguments)
    code = end.value.code
    return (code, said.getvalue()) if isinstance(code, int) else (1, str(code))
