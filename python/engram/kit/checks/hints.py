"""Lines of a task that use what differs from run to run."""

from __future__ import annotations

import ast
import inspect
import sys
from collections.abc import Iterator

from engram.kit.task import Task

_MODULES = ("random", "time", "datetime", "secrets", "uuid")


def suspicious_lines(task: Task) -> str:
    """The calls in words, such as " (line 31: np.random.rand)"; empty if there are none."""
    module = sys.modules.get(type(task).__module__)
    try:
        source = inspect.getsource(module) if module is not None else ""
    except (OSError, TypeError):
        return ""
    found = {f"line {line}: {name}" for line, name in _calls(ast.parse(source))}
    return f" ({'; '.join(sorted(found)[:4])})" if found else ""


def _calls(tree: ast.AST) -> Iterator[tuple[int, str]]:
    classes = [node for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]
    functions = [node for cls in classes for node in ast.walk(cls)
                 if isinstance(node, ast.FunctionDef) and node.name != "build"]  # fmt: skip
    for function in functions:
        for node in ast.walk(function):
            if isinstance(node, ast.Global):
                yield node.lineno, "global " + ", ".join(node.names)
            if isinstance(node, ast.Call):
                name = ast.unparse(node.func)
                parts = name.split(".")
                if parts[0] in _MODULES or "random" in parts[:-1] or name in (
                    "hash", "id", "os.urandom"
                ):  # fmt: skip
                    yield node.lineno, name
