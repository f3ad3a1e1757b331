"""Linters of LeRobot data sets, as released, on one of ours."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

pytest.importorskip("lerobot_doctor")

from demonstrations import COMMAND

from engram.datasets.__main__ import main

ID = "ShellGamePick-VLA-v0"


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    folder = tmp_path_factory.mktemp("linted")
    command = [*COMMAND, "collect", ID, "--episodes=4", "--labels", "--out", folder]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    assert main(["lerobot", str(folder), "--labels"]) == 0
    return folder / "data_lerobot" / ID


def run(program: str, *words: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", program, *words], capture_output=True, text=True, check=False
    )
    return done.stdout + done.stderr


def test_lerobot_doctor_finds_no_failure(path):
    said = " ".join(run("from lerobot_doctor.cli import main; main()", str(path)).split())
    assert "[PASS] Feature Consistency" in said
    assert "[PASS] Temporal Consistency" in said
    assert "[FAIL]" not in said
    # Texts have no statistics; all numbers have.
    assert "not in stats.json: ['language_events', 'language_persistent']" in said


def test_deepen_grade_finds_no_defect(path):
    program = "from deepen_grade.cli import main; main()"
    said = run(program, "grade", str(path), "--format", "lerobot", "--json")
    report = json.loads(said[said.index("{") : said.rindex("}") + 1])
    assert report["overall"]["grade"] == "A", report["overall"]
