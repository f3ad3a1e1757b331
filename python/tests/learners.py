"""The learners of python/examples/memory, for tests: modules, and scripts as processes."""

from __future__ import annotations

import contextlib
import importlib
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

FOLDER = Path(__file__).parents[1] / "examples" / "memory"


@contextlib.contextmanager
def modules(*names: str, **renamed: str) -> Iterator[SimpleNamespace]:
    """Modules of the folder, which is on the search path for as long."""
    import torch

    before = set(sys.modules)
    sys.path.insert(0, str(FOLDER))
    torch.set_num_threads(1)  # as the scripts do
    try:
        named = dict.fromkeys(names) | renamed
        found = {name: importlib.import_module(of or name) for name, of in named.items()}
        yield SimpleNamespace(**found)
    finally:
        sys.path.remove(str(FOLDER))
        for name in set(sys.modules) - before:
            if str(FOLDER) in str(getattr(sys.modules[name], "__file__", "")):
                del sys.modules[name]


def find_objects(detector: Any) -> None:
    """Makes an untrained detector find some objects, or nothing is tested."""
    import torch

    with torch.no_grad():
        detector.peak.bias += 4.0
        detector.name.bias[-1] -= 2.0


def run(script: str, *arguments: str) -> list[str]:
    """The lines that a script prints."""
    command = [sys.executable, str(FOLDER / script), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()
