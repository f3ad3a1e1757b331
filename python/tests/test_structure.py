"""tools/structure.py: how it counts."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
import structure  # noqa: E402

sys.path.pop(0)

BATCH = """
class Batch {
 public:
  Batch(int num_envs);
  void step(std::span<const float> actions);  // see reset()
  int num_envs() const { return num_envs_(); }

 private:
  friend class Queries;
  int num_envs_() const;
};
"""
FILES = {
    "core/batch/batch.h": BATCH,
    "core/batch/options.cc": '#include "core/batch/batch.h"\n// The same.\nint latency;\n',
    "api/options.cc": (
        "int own;\n// begin generated: latency (tools, from a table)\nint latency;\n"
        "// end generated\nint more;\n// Of a row.\nint other;\n"
        "// begin rl: written by tools\nint latency;\n// end rl\n"
    ),
    "tests/core/batch_test.cc": "int latency;\n",
    "python/examples/one.py": 'import helper\n\nif __name__ == "__main__":\n    helper.run()\n',
    "python/examples/helper.py": "def run():\n    pass\n",
    "python/examples/two.py": 'import one\n\nif __name__ == "__main__":\n    one.helper.run()\n',
    "scripts/build.sh": "#!/bin/sh\n",
    "scripts/help.sh": "# Sourced.\n",
    "README.md": "# Two words\n",
}


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    subprocess.run(["git", "-C", tmp_path, "init", "--quiet"], check=True)
    return tmp_path


def test_measures_of_a_small_tree(tree: Path) -> None:
    rows = {name: (value, findings) for name, value, findings in structure.measure(tree)}
    assert rows["core: units, includes, floors"][0] == "2, 1, 2"
    assert rows["public methods of Batch"] == ("2", ["step", "num_envs"])
    assert rows["friends of Batch"] == ("1", ["Queries"])
    assert rows["comment blocks that lean on others"][1] == [
        "api/options.cc:6: Of a row.",
        "core/batch/options.cc:2: The same.",
    ]
    assert rows["modules behind the largest example"] == ("2", ["2 one", "2 two"])
    assert rows["pages, words"][0] == "1, 3"
    assert rows["programs of scripts and tools"][1] == ["scripts/build.sh"]
    assert rows["lines that are generated"][0] == "6"


def test_files_that_name_an_option_by_hand(tree: Path) -> None:
    assert structure.naming(tree, "latency") == ["core/batch/options.cc"]


def test_files_of_a_change(tree: Path) -> None:
    def commit() -> None:
        identity = ["-c", "user.name=a", "-c", "user.email=a@example.org"]
        subprocess.run(["git", "-C", tree, "add", "--all"], check=True)
        words = ["git", "-C", tree, *identity, "commit", "--quiet", "--message", "Add files"]
        subprocess.run(words, check=True)

    commit()
    for name in ("api/options.cc", "core/batch/options.cc"):
        (tree / name).write_text(FILES[name].replace("latency;", "delay;"))
    commit()
    files, own = structure.touched(tree, "HEAD~..HEAD")
    assert files == ["api/options.cc", "core/batch/options.cc"]
    assert own == ["core/batch/options.cc"]
