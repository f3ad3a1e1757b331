"""Files of users' tasks: libraries, and Python such as ``my_tasks.py:LampOrder-v0``."""

from __future__ import annotations

import hashlib
import os
import sys
from pathlib import Path

from engram import _core
from engram._args import values
from engram._io.source_file import run_file
from engram.errors import InvalidArgumentError, IoError
from engram.gym_registration import register

# Files of ENGRAM_TASKS that are loaded, with their ids.
environment_files: dict[Path, list[str]] = {}


def split_target(target: str) -> tuple[str | None, str | None]:
    """File and id of a target such as "my_tasks.py:LampOrder-v0"; either may be None."""
    values.text("target", target)
    if target.endswith(".py"):
        return target, None
    file, colon, id = target.rpartition(":")
    if colon and file.endswith(".py"):
        return file, id or None
    return None, target


def load_file(path: str | os.PathLike[str]) -> list[str]:
    """Runs a file with tasks, as an import would, and returns the ids that it registered.

    Modules beside the file can be imported by it. Exceptions of the file come out as they are.

    Raises:
        IoError: There is no such file.
        InvalidArgumentError: The file registers no task.
    """
    from engram.kit.registration import definitions

    file = Path(values.path("path", path)).resolve()
    if not file.is_file():
        raise IoError(f"{file}: no such file")
    if file.suffix != ".py":
        raise InvalidArgumentError(f"path: {os.fspath(path)!r} given; a Python file needed")
    before = dict(definitions)
    sys.path.insert(0, str(file.parent))
    try:
        run_file(_module_name(file), file)
    finally:
        sys.path.remove(str(file.parent))
    found = [id for id, one in definitions.items() if before.get(id) is not one]
    if not found:
        raise InvalidArgumentError(f"{file}: registers no task; engram.register_task(...) does")
    return found


def load_environment() -> None:
    """Loads the Python files that ENGRAM_TASKS names, separated by ':'; once.

    Its libraries are loaded by the first call that looks for ids, and then variants of all tasks.
    """
    from engram.kit import registration

    registration.gymnasium_waits = True
    try:
        for file in os.environ.get("ENGRAM_TASKS", "").split(os.pathsep):
            if file.endswith(".py"):
                environment_files[Path(file).resolve()] = load_file(file)
    finally:
        registration.gymnasium_waits = False


def load_tasks(path: str | os.PathLike[str]) -> None:
    """Loads a file of tasks, here and for Gymnasium.

    It stays loaded for the life of the process; the same library twice is one. Its code runs with
    all rights of the process.

    Args:
        path: A library (docs/cpp_tasks.md), such as "libtouch_spot.so", or a Python file
            (docs/custom_tasks.md), whose name ends in .py.

    Raises:
        IoError: The file cannot be read.
        InvalidArgumentError: It is no such library, was made for another version of engram or with
            another ABI, one of its ids is taken, or a Python file registers no task. Exceptions of
            a Python file come out as they are.
    """
    if os.fspath(path).endswith(".py"):
        load_file(path)
        return
    _core.load_tasks(values.path("path", path))
    register()


def _module_name(file: Path) -> str:
    """The name that an import would use, unless another module has it."""
    taken = sys.modules.get(file.stem)
    if taken is None or getattr(taken, "__file__", None) == str(file):
        return file.stem
    return f"{file.stem}_{hashlib.sha256(str(file).encode()).hexdigest()[:8]}"
