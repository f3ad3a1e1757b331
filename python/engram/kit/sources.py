"""Sources of a task's class by content, for results to name."""

from __future__ import annotations

import ast
import hashlib
import inspect
import sys
from collections.abc import Iterator
from pathlib import Path

from engram.kit.task import Task


def source_of(cls: type[Task]) -> str:
    """SHA-256 of the files of a class and its bases, with those beside them that they import.

    A class without a file, such as one of a notebook, is named by its own lines; "" where there are
    none.
    """
    files: dict[Path, str] = {}
    lines = []
    for one in cls.__mro__:
        if one is Task or not issubclass(one, Task):
            continue
        file = _file_of(one)
        if file is None:
            lines.append(_lines_of(one))
        else:
            _add(file, file.parent, files)
    pieces = sorted((name, path.read_bytes()) for path, name in files.items())
    pieces += [("", text.encode()) for text in lines if text]
    if not pieces:
        return ""
    digest = hashlib.sha256()
    for name, content in pieces:
        digest.update(f"{len(name)} {name} {len(content)} ".encode() + content)
    return digest.hexdigest()


def _file_of(cls: type) -> Path | None:
    name = getattr(sys.modules.get(cls.__module__), "__file__", None)
    path = Path(name).resolve() if name else None
    return path if path is not None and path.is_file() else None


def _lines_of(cls: type) -> str:
    try:
        return inspect.getsource(cls)
    except (OSError, TypeError):
        return ""


def _add(file: Path, folder: Path, files: dict[Path, str]) -> None:
    """Adds a file under its name in the folder, and all in that folder that it imports."""
    if file in files:
        return
    files[file] = file.relative_to(folder).as_posix()
    try:
        tree = ast.parse(file.read_bytes())
    except (SyntaxError, ValueError):
        return
    for start, name in _imports(tree, file, folder):
        for found in _beside(start, name):
            if found.is_relative_to(folder):
                _add(found, folder, files)


def _imports(tree: ast.AST, file: Path, folder: Path) -> Iterator[tuple[Path, list[str]]]:
    """Imported names in parts, each with the folder in which Python looks for it."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield folder, alias.name.split(".")
        elif isinstance(node, ast.ImportFrom):
            start = file.parents[node.level - 1] if node.level else folder
            module = node.module.split(".") if node.module else []
            for alias in node.names:
                yield start, [*module, alias.name]


def _beside(folder: Path, parts: list[str]) -> Iterator[Path]:
    """Files that an import of these parts runs, as far as they are in the folder."""
    for part in parts:
        for found in (folder / f"{part}.py", folder / part / "__init__.py"):
            if found.is_file():
                yield found.resolve()
        folder = folder / part
