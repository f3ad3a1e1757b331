"""Structure of the package: no circular imports, few modules at the first level."""

from __future__ import annotations

import ast
import importlib
import subprocess
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path

import pytest

import engram
from engram._deprecated import MOVED

PACKAGE = Path(engram.__file__).parent
# Modules and packages side by side in python/engram, without former names.
FIRST_LEVEL = {
    "__init__", "__main__", "_args", "_core", "_deprecated", "_ids", "command", "datasets", "envs",
    "errors", "evaluation", "factory", "gym_registration", "integrations", "mikasa", "play",
    "scores", "tasks", "typing",
}  # fmt: skip


def modules() -> dict[str, Path]:
    """Source files by the name of their module."""
    found = {}
    for file in PACKAGE.rglob("*.py"):
        parts = file.relative_to(PACKAGE.parent).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = file
    return found


MODULES = modules()


def imports(name: str) -> Iterator[str]:
    """Modules of the package that a module imports, at its top, in functions or for checkers."""
    for node in ast.walk(ast.parse(MODULES[name].read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in MODULES)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{name}: a relative import"
            for alias in node.names:
                whole = f"{node.module}.{alias.name}"
                if whole == "engram._core":
                    continue  # the extension
                if whole in MODULES:
                    yield whole
                elif node.module in MODULES:
                    yield str(node.module)


def circle(graph: dict[str, set[str]]) -> list[str]:
    """Nodes of a circle, if there is one."""
    done: set[str] = set()
    path: list[str] = []

    def visit(node: str) -> list[str]:
        if node in path:
            return [*path[path.index(node) :], node]
        if node in done:
            return []
        path.append(node)
        for other in sorted(graph.get(node, ())):
            if found := visit(other):
                return found
        done.add(path.pop())
        return []

    return next((found for node in sorted(graph) if (found := visit(node))), [])


def test_a_circle_is_found():
    assert circle({"a": {"b"}, "b": {"c"}, "c": set()}) == []
    assert circle({"a": {"b"}, "b": {"c"}, "c": {"b"}}) == ["b", "c", "b"]


def test_modules_do_not_import_each_other_in_circles():
    graph = {name: set(imports(name)) - {name} for name in MODULES}
    assert {"engram.envs.vector_env", "engram.typing"} <= graph["engram.factory"]
    assert " -> ".join(circle(graph)) == ""


def test_packages_do_not_import_each_other_in_circles():
    """A module at the first level and all that is below it count as one."""

    def unit(name: str) -> str:
        return ".".join(name.split(".")[:2])

    graph: dict[str, set[str]] = {}
    for name in MODULES:
        graph.setdefault(unit(name), set()).update(unit(other) for other in imports(name))
    for name, others in graph.items():
        others.discard(name)
    assert " -> ".join(circle(graph)) == ""


def test_the_first_level_is_narrow():
    found = {
        path.stem.split(".")[0]
        for path in PACKAGE.iterdir()
        if (path.is_dir() and any(path.glob("*.py"))) or path.suffix in (".py", ".so")
    }
    assert found <= FIRST_LEVEL


# Only the environment of the data tests has LeRobot (tests/clients/data/test_lerobot_rollout.py).
@pytest.mark.parametrize("name", sorted(set(MOVED) - {"lerobot"}))
def test_former_names_lead_to_the_new_modules(name):
    sys.modules.pop(f"engram.{name}", None)
    with pytest.warns(DeprecationWarning, match=rf"engram\.{name} is now engram\."):
        old = importlib.import_module(f"engram.{name}")
    assert old is importlib.import_module(f"engram.{MOVED[name]}")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert getattr(engram, name) is old
    assert name in {path.stem for path in (PACKAGE / "_deprecated").iterdir()}


def test_engram_itself_uses_no_former_name():
    command = [sys.executable, "-W", "error::DeprecationWarning:engram", "-c", "import engram"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
