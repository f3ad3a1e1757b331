"""Suites of tools/measure.py: what they compute, and how they refuse."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
import measure  # noqa: E402
from measurements import bench, check, common, memory, random_draws, summary  # noqa: E402

sys.path.pop(0)


def command(folder: Path, text: str) -> str:
    """A program in place of engram."""
    file = folder / "engram"
    file.write_text(f"#!/bin/sh\n{text}\n")
    file.chmod(0o755)
    return str(file)


def test_the_page_has_the_figures_of_its_files() -> None:
    page = common.PAGE.read_text()
    assert summary.summarised(page) == page
    row = next(line for line in page.splitlines() if line.startswith("| scores.csv, oracle |"))
    assert summary.summarised(page.replace(row, row.replace("38", "37"))) == page


def test_rates_are_those_of_the_command(monkeypatch: pytest.MonkeyPatch) -> None:
    assert list(check.stale_rates("")) == []
    rows = common.read_csv("memory.csv")
    rows[1]["sweep"] = "0.985"
    monkeypatch.setattr(check, "read_csv", lambda _: rows[1:])
    problems = sorted(check.stale_rates(""))
    assert [problem.split(": ")[1] for problem in problems] == [
        "ShellGamePush-VLA-v0",
        "ShellGameTouch-VLA-v0",
    ]


def test_rows_of_policies_without_memory() -> None:
    def task(rate: float, answer: float | None) -> dict[str, Any]:
        return {"sr": rate, "chance": 1 / 3, "answer_chance": 0.25, "first_answer_correct": answer}

    results = {policy: {"A": task(0.5, 0.2), "B": task(1, None)} for policy in memory.POLICIES}
    strict = {policy: {"A": task(0.1, 0.2)} for policy in memory.POLICIES}
    measured = {"results": results, "strict": strict, "pose": {"B": task(0.9, None)}}
    rates = ["0.500"] * 3, ["0.200"] * 3, ["0.100"] * 3
    assert memory.rows_of(measured) == [
        ["A", "0.333", *rates[0], "0.250", *rates[1], *rates[2], ""],
        ["B", "0.333", *["1.000"] * 3, "0.250", *[""] * 6, "0.900"],
    ]
    assert '    {"B", 1, 1, 1, -1, -1, -1},' in memory.figures(results)


def test_chi_squared_of_hidden_numbers() -> None:
    chi, counts = random_draws.chi_squared(3, [[1]] * 22 + [[2]] * 14 + [[3]] * 14)
    assert (round(chi, 6), counts[1]) == (2.56, 22)
    assert random_draws.tail(3.841, 1) == pytest.approx(0.05, abs=0.003)
    assert random_draws.limit(3, 1, 50) == 27
    task = {"first_answers": [12, 31], "first_answers_correct": [True, False]}
    about = {"candidates": 60, "answer_chance": 1 / 60}
    assert random_draws.hidden_numbers("SeqOfColors3-VLA-v0", task, about) == (9, [[1, 2]])
    assert random_draws.hidden_numbers("Others", task, about) is None


def test_shares_of_a_step_are_one_row() -> None:
    rows = [
        {"name": f"budget.A-VLA-v0.rgb.{part}", "baseline_value": 4.8261, "ratio": ratio}
        for part, ratio in (("controller", 0.0221), ("render", 0.5))
    ]
    assert list(bench.budget_rows("random", rows)) == [
        ["policy", "id", "obs", "us", "controller", "render"],
        ["random", "A-VLA-v0", "rgb", "4.826", "2.2", "50.0"],
    ]


@pytest.mark.parametrize(("output", "code"), [("same", 0), ("$*", 1)])
def test_other_bytes_of_an_evaluation_are_found(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    output: str,
    code: int,
) -> None:
    engram = command(tmp_path, f'echo "{output}"')
    monkeypatch.setattr("shutil.which", lambda _: None)  # no mpirun
    with pytest.raises(SystemExit) as ended:
        measure.main(["evaluation", "--engram", engram, "--arguments", "TASK"])
    assert ended.value.code == code
    printed = capsys.readouterr().out
    assert "same       threads 1, num-envs 1: " in printed
    assert ("DIFFERENT  threads 2, num-envs 64: " in printed) == bool(code)


def test_a_command_that_fails_ends_a_suite(tmp_path: Path) -> None:
    engram = command(tmp_path, "echo no such task >&2; exit 2")
    before = (common.DATA / "determinism.csv").read_bytes()
    with pytest.raises(SystemExit, match="verify --json: no such task"):
        measure.main(["determinism", "--engram", engram])
    with pytest.raises(SystemExit, match="absent: No such file or directory; --engram names"):
        measure.main(["determinism", "--engram", str(tmp_path / "absent")])
    assert (common.DATA / "determinism.csv").read_bytes() == before
