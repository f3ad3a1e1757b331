"""Runs of the learners in python/examples."""

from __future__ import annotations

import contextlib
import csv
import importlib.util
import io
import runpy
import sys
from pathlib import Path
from types import ModuleType
from unittest import mock

FOLDER = Path(__file__).parents[1] / "examples"


def load(name: str) -> ModuleType:
    """An example as a module."""
    spec = importlib.util.spec_from_file_location(f"{name}_example", FOLDER / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses need it
    with mock.patch.object(sys, "path", [str(FOLDER), *sys.path]):  # as for a script
        spec.loader.exec_module(module)
    return module


def learn(name: str, out: Path, *arguments: str) -> tuple[str, list[dict[str, float]]]:
    """What a run prints, and its log. In this process: another one would import torch again."""
    file, printed = str(FOLDER / f"{name}.py"), io.StringIO()
    words = [file, "--out", str(out), *arguments]
    with mock.patch.object(sys, "argv", words), contextlib.redirect_stdout(printed):
        runpy.run_path(file, run_name="__main__")
    with (out / "log.csv").open(newline="") as log:
        rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(log)]
    return printed.getvalue(), rows
