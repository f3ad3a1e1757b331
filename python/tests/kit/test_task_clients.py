"""The browser's page and data sets with tasks of a user's file."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from play_server import play_oracle, serving

from engram import kit

EXAMPLES = Path(__file__).parents[2] / "examples" / "own_tasks"
FILE = EXAMPLES / "remember_color.py"
TASK = "MyRememberColor9-v0"


@pytest.fixture(scope="module")
def ids() -> list[str]:
    return kit.load_file(FILE)


@pytest.mark.parametrize(
    "words", [("engram", "--tasks", str(FILE), "play"), ("engram.play", "--tasks", str(FILE))]
)
def test_its_tasks_are_played_in_the_browser(
    tmp_path: Path, ids: list[str], words: tuple[str, ...]
) -> None:
    assert ids == [TASK]
    with serving(tmp_path, command=words) as server:
        assert TASK in [one["id"] for one in server.get("tasks.json")]
        with server.page() as page:
            page.receive("hello")
            assert play_oracle(page, TASK, 5)["success"]


def test_its_demonstrations_are_replayed(tmp_path: Path) -> None:
    def run(*words: object) -> str:
        command = [sys.executable, "-m", *map(str, words)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    run("engram", "collect", f"{FILE}:{TASK}", "--episodes", 3, "--out", tmp_path)
    replayed = json.loads(run("engram.datasets", "replay", tmp_path, "--tasks", FILE, "--json"))
    assert [(one["episodes"], one["equal"]) for one in replayed] == [(3, True)]
