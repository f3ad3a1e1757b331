"""Structure of the package: no circular imports, few modules at the first level."""

from __future__ import annotations

import fnmatch
import re
import subprocess
import sys
from pathlib import Path

import engram

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
from structure import circles, python_modules  # noqa: E402

PACKAGE = Path(engram.__file__).parent
# Modules and packages side by side in python/engram.
FIRST_LEVEL = {
    "__init__", "__main__", "_args", "_core", "_distribution", "_ids",
    "_interpreter", "_io", "command",
    "datasets", "envs", "errors", "evaluation", "factory", "gym_registration", "integrations",
    "kit", "mikasa", "play", "servers", "tasks", "typing", "wrappers",
}  # fmt: skip


MODULES = python_modules(ROOT)


def test_imports_are_absolute():
    relative = re.compile(r"^\s*from \.", re.MULTILINE)
    assert not [file for file in PACKAGE.rglob("*.py") if relative.search(file.read_text())]


def test_a_circle_is_found():
    assert circles({"a": {"b"}, "b": {"c"}, "c": set()}) == []
    assert circles({"a": {"b"}, "b": {"c"}, "c": {"b"}}) == [["b", "c"]]


def test_modules_do_not_import_each_other_in_circles():
    assert {"engram.envs.vector_env", "engram.typing"} <= MODULES["engram.factory"]
    assert circles(MODULES) == []


def test_packages_do_not_import_each_other_in_circles():
    """A module at the first level and all that is below it count as one."""

    def unit(name: str) -> str:
        return ".".join(name.split(".")[:2])

    graph: dict[str, set[str]] = {}
    for name, others in MODULES.items():
        graph.setdefault(unit(name), set()).update(unit(other) for other in others)
    for name, others in graph.items():
        others.discard(name)
    assert circles(graph) == []


def test_the_first_level_is_narrow():
    found = {
        path.stem.split(".")[0]
        for path in PACKAGE.iterdir()
        if (path.is_dir() and any(path.glob("*.py"))) or path.suffix in (".py", ".so")
    }
    assert found <= FIRST_LEVEL


def test_no_import_needs_the_command():
    """Debian's package of the Python files leaves out its folder; imports in functions count."""
    needs = re.compile(r"^\s*(from|import) engram\.command\b", re.MULTILINE)
    files = {file.relative_to(PACKAGE) for file in PACKAGE.rglob("*.py")}
    rest = {file for file in files if file.parts[0] not in ("command", "__main__.py")}
    assert Path("mikasa/record.py") in rest
    assert not [file for file in rest if needs.search((PACKAGE / file).read_text())]


def test_the_debian_package_has_all_kinds_of_files():
    """All but the command, which is a package of its own there."""
    text = (ROOT / "python" / "CMakeLists.txt").read_text()
    rule = text[text.index("FILES_MATCHING") :]
    patterns = re.findall(r'PATTERN "([^"]+)"(?! EXCLUDE)', rule[: rule.index(")")])
    folder = ROOT / "python" / "engram"
    files = [
        file
        for file in folder.rglob("*")
        if file.is_file() and not {"__pycache__", "command"} & {*file.parts}
    ]
    assert "font.npz" in {file.name for file in files}
    assert not [file for file in files if not any(fnmatch.fnmatch(file.name, p) for p in patterns)]


def test_wrappers_and_kit_need_no_import_of_their_own():
    words = [sys.executable, "-c", "import engram; engram.wrappers.EqualStarts, engram.kit.Cube"]
    subprocess.run(words, check=True)
