"""The catalogue of tasks that the page lists."""

from __future__ import annotations

from pathlib import Path

from engram import kit
from engram.play.catalogue import Catalogue

EXAMPLES = Path(__file__).parents[2] / "examples" / "own_tasks"


def test_own_tasks_are_marked():
    ids = kit.load_file(EXAMPLES / "remember_button.py")
    listed = Catalogue().list()
    assert {task["id"] for task in listed if task["own"]} >= set(ids)
    assert not any(task["own"] for task in listed if task["id"] == "RememberColor3-VLA-v0")
