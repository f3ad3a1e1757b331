"""python -m engram_learners.scores: resumed runs, and the tables."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import engram
from engram_learners.scores import interval, main

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
result["wiped"] = {"success_once": 0.3}
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


def test_scores_of_a_task(tmp_path: Path, learners: Path) -> None:
    out = tmp_path / "runs"
    arguments = [COLOR3, "--seeds", "1", "2", "--learners", str(learners), "--out", str(out)]
    assert main(arguments) == 0
    page = (out / "scores.md").read_text()
    assert "recurrent 0 of 1" in page
    assert f"| {COLOR3} | 0.650 (0.60-0.70; 0.60) |" in page
    assert f"| {COLOR3} | 1.5, 1.5 | 1.5, 1.5 | 1.5, 1.5 |" in page
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


def test_a_page_of_several_splits_has_the_columns_that_ran(tmp_path: Path, learners: Path) -> None:
    task = "RememberColor3-Long-VLA-v0"
    page = tmp_path / "page.md"
    arguments = ["--only", "distilled", "--seeds", "1", "--out", str(tmp_path), "--page", str(page)]
    assert main([task, *arguments, "--learners", str(learners)]) == 0
    assert main(["--split", "medium", "long", *arguments, "--tables"]) == 0
    success = page.read_text().split("## ")[1].splitlines()
    rows = [line.split(" | ") for line in success if line.startswith("| ")]
    assert rows[0] == ["| id", "distilled |"]
    cells = {row[0].removeprefix("| "): row[1] for row in rows[1:] if "VLA" in row[0]}
    for variant in [t["id"] for t in engram.list() if not t["canonical"]]:  # of other tests
        cells.pop(variant, None)
    assert len(cells) == 30 + 22
    assert cells.pop(task).startswith("0.600")
    assert set(cells.values()) == {"- |"}  # not run


def test_a_page_keeps_its_text(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("# Who remembers\n\n<!-- scores -->\nold\n<!-- end of scores -->\n\nThe end.\n")
    out = tmp_path / "runs"
    arguments = [
        INTERCEPT,
        "--only",
        "oracle",
        "--seeds",
        "1",
        "--out",
        str(out),
        "--page",
        str(page),
    ]
    assert main(arguments) == 0
    text = page.read_text()
    assert text.startswith("# Who remembers\n")
    assert text.endswith("\n\nThe end.\n")
    assert "old" not in text
    answers = text.split("## The first answer is right")[1]
    assert INTERCEPT not in answers.split("##")[0]  # it asks for no answer


def test_runs_beside_the_page_are_not_repeated(tmp_path: Path, learners: Path) -> None:
    page, first, second = (tmp_path / name for name in ("page.md", "first", "second"))
    arguments = [COLOR3, "--only", "recurrent", "--learners", str(learners), "--page", str(page)]
    assert main([*arguments, "--out", str(first), "--seeds", "1"]) == 0
    assert main([*arguments, "--out", str(second), "--seeds", "1", "2"]) == 0
    assert (second / COLOR3 / "calls.txt").read_text().split() == ["2"]
    assert "0.650 (0.60-0.70; 0.60)" in page.read_text()
    file = page.with_suffix(".json")
    file.write_text(file.read_text().replace(engram.__version__, "0.1.0"))
    with pytest.raises(SystemExit, match=r"results of engram 0\.1\.0 given"):
        main([*arguments, "--out", str(second)])


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
    run.write_text(good.replace("0.6", "1.0"))
    with pytest.raises(SystemExit, match=r"run\.json: its checksum does not fit"):
        main([*arguments, "--tables"])
    (out / COLOR3 / "distilled-2").mkdir()
    (out / COLOR3 / "distilled-2" / "run.json").write_text(good)
    run.write_text(good)
    with pytest.raises(SystemExit, match="not of its folder"):
        main([*arguments, "--tables"])
    (out / COLOR3 / "distilled-2" / "run.json").unlink()
    # A result without its origin is not known: the run is repeated.
    (out / "scores.json").unlink()
    run.unlink()
    calls = out / COLOR3 / "calls.txt"
    calls.unlink()
    assert main(arguments) == 0
    assert calls.read_text().split() == ["1"]
    page = out / "scores.json"
    page.write_text(page.read_text().replace("0.6", "1.0"))
    with pytest.raises(SystemExit, match=r"scores\.json: its checksum does not fit"):
        main([*arguments, "--tables"])
