"""python -m engram_learners.scores: resumed runs, and the tables."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import engram
from engram_learners.scores import interval, main, read_runs, store

COLOR3 = "RememberColor3-VLA-v0"
INTERCEPT = "InterceptSlow-VLA-v0"

LEARNER = """
import argparse, json, pathlib
parser = argparse.ArgumentParser()
for name in ("--id", "--seed", "--out"):
    parser.add_argument(name)
parser.add_argument("--no-memory", action="store_true")
args = parser.parse_args()
out = pathlib.Path(args.out)
with (out.parent / "calls.txt").open("a") as calls:
    calls.write(args.seed + "\\n")
if (out.parent / "broken").exists():
    raise SystemExit("broken")
rate = 0.5 + 0.1 * int(args.seed)
result = {"success_once": rate, "first_answer_correct": rate, "cpu_s": 90}
result["wiped"] = {"success_once": 0.375}
(out / "result.json").write_text(json.dumps(result))
"""


@pytest.fixture
def learners(tmp_path: Path) -> Path:
    folder = tmp_path / "learners"
    folder.mkdir()
    for name in ("ppo_recurrent.py", "distil.py"):
        (folder / name).write_text(LEARNER)
    return folder


def test_interval_is_wilsons() -> None:
    low, high = interval(0.9, 200)
    assert (round(low, 4), round(high, 4)) == (0.8506, 0.9343)
    assert interval(0.0, 200)[0] == 0
    assert interval(1.0, 200)[1] == 1


Printed = pytest.CaptureFixture[str]


def tables_of(arguments: list[str], capsys: Printed) -> str:
    """Tables that these arguments print."""
    capsys.readouterr()
    assert main([*arguments, "--tables"]) == 0
    return capsys.readouterr().out


def test_scores_of_a_task(tmp_path: Path, learners: Path, capsys: Printed) -> None:
    out = tmp_path / "runs"
    arguments = [COLOR3, "--seeds", "1", "2", "--learners", str(learners), "--out", str(out)]
    assert main(arguments) == 0
    text = capsys.readouterr().out
    assert "recurrent 0 of 1" in text
    assert f"| {COLOR3} | 0.650 (0.60-0.70; 0.60) |" in text
    assert f"| {COLOR3} | 1.5, 1.5 | 1.5, 1.5 | 1.5, 1.5 |" in text
    assert tables_of(arguments, capsys) == text[text.index("Tasks with") :]
    oracle = json.loads((out / COLOR3 / "oracle-1" / "result.json").read_text())
    blind = json.loads((out / COLOR3 / "blind-1" / "result.json").read_text())
    assert oracle["success_once"] == 1
    assert 0.2 < blind["success_once"] < 0.47


def test_finished_runs_are_not_repeated(tmp_path: Path, learners: Path) -> None:
    out = tmp_path / "runs"
    arguments = [COLOR3, "--only", "distilled", "--learners", str(learners), "--out", str(out)]
    arguments += ["--jobs", "1", "--seeds", "1", "2", "3"]
    (out / COLOR3).mkdir(parents=True)
    broken = out / COLOR3 / "broken"
    broken.touch()
    with pytest.raises(RuntimeError, match=r"see .*output\.txt"):
        main(arguments)
    assert "broken" in (out / COLOR3 / "distilled-1" / "output.txt").read_text()
    broken.unlink()
    calls = out / COLOR3 / "calls.txt"
    calls.unlink()
    assert main(arguments) == 0
    assert sorted(calls.read_text().split()) == ["1", "2", "3"]
    assert main(arguments) == 0
    assert len(calls.read_text().split()) == 3


def test_tables_of_several_splits_have_the_columns_that_ran(
    tmp_path: Path, learners: Path, capsys: Printed
) -> None:
    task = "RememberColor3-Long-VLA-v0"
    arguments = ["--only", "distilled", "--seeds", "1", "--out", str(tmp_path)]
    assert main([task, *arguments, "--learners", str(learners)]) == 0
    text = tables_of(["--split", "medium", "long", *arguments], capsys)
    success = text.split("## ")[1].splitlines()
    rows = [line.split(" | ") for line in success if line.startswith("| ")]
    assert rows[0] == ["| id", "distilled |"]
    cells = {row[0].removeprefix("| "): row[1] for row in rows[1:] if "VLA" in row[0]}
    for variant in [t["id"] for t in engram.list() if not t["canonical"]]:  # of other tests
        cells.pop(variant, None)
    assert len(cells) == 30 + 22
    assert cells.pop(task).startswith("0.600")
    assert set(cells.values()) == {"- |"}  # not run


def test_a_task_that_asks_for_no_answer_has_none(tmp_path: Path, capsys: Printed) -> None:
    arguments = [INTERCEPT, "--only", "oracle", "--seeds", "1", "--out", str(tmp_path)]
    assert main(arguments) == 0
    text = tables_of(arguments, capsys)
    assert INTERCEPT in text.split("## success_once")[1].split("##")[0]
    assert INTERCEPT not in text.split("## The first answer is right")[1].split("##")[0]


def test_runs_of_the_file_are_not_repeated(tmp_path: Path, learners: Path, capsys: Printed) -> None:
    file, first, second = (tmp_path / name for name in ("runs.csv", "first", "second"))
    arguments = [COLOR3, "--only", "recurrent", "--learners", str(learners), "--file", str(file)]
    assert main([*arguments, "--out", str(first), "--seeds", "1"]) == 0
    assert main([*arguments, "--out", str(second), "--seeds", "1", "2"]) == 0
    assert (second / COLOR3 / "calls.txt").read_text().split() == ["2"]
    assert "0.650 (0.60-0.70; 0.60)" in tables_of([*arguments, "--out", str(second)], capsys)
    file.write_text(file.read_text().replace(engram.__version__, "0.1.0"))
    with pytest.raises(SystemExit, match=r"results of engram 0\.1\.0 given"):
        main([*arguments, "--out", str(second)])


def test_rows_keep_every_figure(tmp_path: Path) -> None:
    runs = {
        (COLOR3, "distilled", 1): {
            "success_once": 1.0,
            "first_answer_correct": None,
            "init": COLOR3,
            "env_steps": 32000,
            "transfer": {INTERCEPT: {"success_once": -0.42538461089134216}},
        },
        (COLOR3, "oracle", 2): {"success_once": 0.5},
    }
    store(runs, tmp_path / "runs.csv")
    read = read_runs(tmp_path / "runs.csv")
    assert read[COLOR3, "distilled", 1] == runs[COLOR3, "distilled", 1]
    given = {key: value for key, value in read[COLOR3, "oracle", 2].items() if value is not None}
    assert given == {"success_once": 0.5}


def test_results_of_another_version_or_edited_ones_are_not_published(
    tmp_path: Path, learners: Path
) -> None:
    out = tmp_path / "runs"
    arguments = [COLOR3, "--only", "distilled", "--learners", str(learners), "--out", str(out)]
    arguments += ["--seeds", "1"]
    assert main(arguments) == 0
    run = out / COLOR3 / "distilled-1" / "run.json"
    good = run.read_text()
    run.write_text(good.replace(engram.__version__, "0.1.0"))
    with pytest.raises(SystemExit, match=r"run\.json: results of engram 0\.1\.0 given"):
        main([*arguments, "--tables"])
    run.write_text(good.replace("0.375", "1.0"))
    with pytest.raises(SystemExit, match=r"run\.json: its checksum does not fit"):
        main([*arguments, "--tables"])
    (out / COLOR3 / "distilled-2").mkdir()
    (out / COLOR3 / "distilled-2" / "run.json").write_text(good)
    run.write_text(good)
    with pytest.raises(SystemExit, match="not of its folder"):
        main([*arguments, "--tables"])
    (out / COLOR3 / "distilled-2" / "run.json").unlink()
    # A result without its origin is not known: the run is repeated.
    (out / "scores.csv").unlink()
    run.unlink()
    calls = out / COLOR3 / "calls.txt"
    calls.unlink()
    assert main(arguments) == 0
    assert calls.read_text().split() == ["1"]
    file = out / "scores.csv"
    file.write_text(file.read_text().replace("0.375", "1.0"))
    with pytest.raises(SystemExit, match=r"scores\.csv:2: its checksum does not fit"):
        main([*arguments, "--tables"])
