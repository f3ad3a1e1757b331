"""tools/changed_tests.py: tests that a change can reach."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
import changed_tests  # noqa: E402

sys.path.pop(0)

FILES = {
    "core/base/index.h": "",
    "core/base/index.cc": '#include "core/base/index.h"\n',
    "core/batch/batch.h": '#include "core/base/index.h"\n',
    "core/batch/reset.h": "",
    "tests/helpers.h": '#include "core/batch/batch.h"\n// Reads colors.csv.\n',
    "tests/core/base/index_test.cc": '#include "core/base/index.h"\n',
    "tests/core/batch/batch_test.cc": '#include "helpers.h"\n',
    "tests/core/other/other_test.cc": "",
    "tests/conventions/words_test.cc": "",
    "tests/data/colors.csv": "",
    "docs/index.md": "",
    "python/src/batch.cc": "",
    "python/engram/__init__.py": "from engram import tasks\ndef f():\n    import engram.play.app",
    "python/engram/__main__.py": "import engram.command",
    "python/engram/command.py": "",
    "python/engram/tasks.py": "",
    "python/engram/play/__init__.py": "",
    "python/engram/play/app.py": "from .session import Session",
    "python/engram/play/session.py": "",
    "python/engram/play/page/play.js": "",
    "python/tests/conftest.py": "import server",
    "python/tests/server.py": "import engram.play.app",
    "python/tests/test_batch.py": "import engram",
    "python/tests/test_command.py": 'run("-m", "engram")',
    "python/tests/test_docs_pages.py": "",
    "python/tests/test_files.py": 'open("colors.csv")',
    "python/tests/test_lazy.py": "import engram\nengram.play.app",
    "python/tests/play/test_page.py": "",
    "python/tests/play/test_tabs.py": "from server import run",
}
CONVENTIONS = "tests/conventions/words_test.cc"


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("tree")
    for name, text in FILES.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    identity = ["-c", "user.name=a", "-c", "user.email=a@example.org"]
    for words in (["init", "-b", "main"], ["add", "."], [*identity, "commit", "-m", "Add files"]):
        subprocess.run(["git", "-C", root, *words], check=True, stdout=subprocess.DEVNULL)
    return root


@pytest.mark.parametrize(
    ("changed", "expected"),
    [
        ("core/base/index.h", {"cpp": ["core/base/index", "core/batch/batch"]}),
        ("core/base/index.cc", {"cpp": ["core/base/index", "core/batch/batch"]}),
        ("core/batch/reset.h", {"cpp": ["core/batch/batch"]}),
        ("tests/core/other/other_test.cc", {"cpp": ["core/other/other"]}),
        ("tests/data/colors.csv", {"cpp": ["core/batch/batch"], "python": ["files"]}),
        ("docs/index.md", {"python": ["docs_pages"]}),
        ("python/engram/tasks.py", {"python": ["batch", "command", "lazy", "play/tabs"]}),
        ("python/engram/command.py", {"python": ["command"]}),
        ("python/engram/play/session.py", {"python": ["lazy", "play/page", "play/tabs"]}),
        ("python/engram/play/page/play.js", {"python": ["play/page", "play/tabs"]}),
        ("python/tests/test_lazy.py", {"python": ["lazy"]}),
    ],
)
def test_what_a_change_of_one_file_reaches(
    tree: Path, changed: str, expected: dict[str, list[str]]
) -> None:
    cpp = [f"tests/{name}_test.cc" for name in expected.get("cpp", [])]
    python = [Path("python/tests", name) for name in expected.get("python", [])]
    (tree / changed).write_text(FILES[changed] + "\n")
    try:
        found = changed_tests.chosen(tree)
    finally:
        (tree / changed).write_text(FILES[changed])
    assert sorted(name for kind, name in found if kind == "cpp") == sorted([*cpp, CONVENTIONS])
    assert sorted(name for kind, name in found if kind == "python") == sorted(
        str(path.with_name(f"test_{path.name}.py")) for path in python
    )


def test_nothing_is_reached_without_a_change(tree: Path) -> None:
    assert changed_tests.chosen(tree) == []


@pytest.mark.parametrize("changed", ["python/src/batch.cc", "python/tests/server.py"])
def test_all_tests_of_python_are_reached(tree: Path, changed: str) -> None:
    """By the binding, and by what a conftest.py imports."""
    (tree / changed).write_text(FILES[changed] + "\n")
    try:
        found = changed_tests.chosen(tree)
    finally:
        (tree / changed).write_text(FILES[changed])
    assert sum(kind == "python" for kind, _ in found) == sum("/test_" in name for name in FILES)
    assert (("binding", changed) in found) == changed.endswith(".cc")


def test_new_files_count_and_a_revision_may_be_given(tree: Path) -> None:
    new = tree / "tests/core/base/new_test.cc"
    new.write_text("")
    try:
        assert ("cpp", "tests/core/base/new_test.cc") in changed_tests.chosen(tree, "HEAD")
    finally:
        new.unlink()
