"""Scores of learners on all tasks of a split.

    python -m engram_learners.scores  # runs what is missing, prints the tables
    python -m engram_learners.scores --split short --jobs 2 --file scores.csv
    python -m engram_learners.scores --split medium long --only distilled --seeds 1

Every learner learns every task from several seeds, each run in a process of its own. Results are
stored under ``--out``; the command can be stopped at any time and continues there.
A CSV file has all runs, a row each. Those in it are not repeated, so that it can be written on
several machines over several days. Results of another version, and edited ones, are refused.
A learner is a script (``--learners`` is their folder) with options ``--id ID --seed S --out
FOLDER`` that writes ``result.json`` to the folder: success_once and first_answer_correct over 200
episodes outside of the training, cpu_s (processor seconds of collecting and learning) and, with a
memory, wiped: the same rates with the memory reset whenever an object appears. Beside it, run.json
holds the same with engram's version and a checksum; without it, a run is repeated.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import io
import itertools
import json
import math
import os
import statistics
import subprocess
import sys
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

import engram
from engram._io import documents
from engram._io.files import open_folder, write_file

__all__ = ["interval", "main", "tables"]

EPISODES = 200
FIRST_SEED = 2_000_000  # of the scored episodes, for policies and learners
LEARNERS = {
    "memoryless": ("ppo_recurrent.py", "--no-memory"),
    "recurrent": ("ppo_recurrent.py",),
    "distilled": ("distil.py",),
}
POLICIES = ("sweep", "blind", "oracle")
RESULT = "result.json"  # of a learner
RUN = "run.json"  # the same, with version and checksum
KEYS = ("id", "learner", "seed")  # of a result that say which run it is


def arguments(given: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m engram_learners.scores", description="Scores of learners, as CSV."
    )
    add = parser.add_argument
    add("ids", nargs="*", metavar="ID", help="tasks; default: those of --split")
    splits = ["short", "medium", "long", "extended", "rl"]
    add("--split", nargs="+", default=["short"], choices=splits)
    add("--seeds", type=int, nargs="+", default=[1, 2, 3], help="of the learners' runs")
    add("--learners", type=Path, default=Path(__file__).parent, help="their folder")
    add("--only", nargs="+", choices=[*LEARNERS, *POLICIES], help="these columns only")
    add("--out", type=Path, default=Path("build/scores"), help="folder of the runs")
    add("--jobs", type=int, default=os.cpu_count() or 1, help="runs at the same time")
    add("--file", type=Path, help="CSV file of all runs; default: OUT/scores.csv")
    add("--tables", action="store_true", help="runs nothing; prints the tables of existing runs")
    add("--pass", dest="more", default="", metavar="'...'", help="further options for learners")
    return parser.parse_args(given)


Column = tuple[str, str]  # task, learner
Run = tuple[str, str, int]  # task, learner, seed
Runs = dict[Run, Any]  # results


# --- results ---


def known_runs(out: Path, file: Path) -> Runs:
    """The results in the file, and those under OUT."""
    runs = read_runs(file) if file.exists() else {}
    for path in sorted(out.glob(f"*/*/{RUN}")):
        stored = _stored(path)
        task, column, seed = stored["run"]
        if folder_of(out, task, column, seed) != path.parent:
            raise SystemExit(f"{path}: the run of {task} {column} {seed}, not of its folder")
        runs[task, column, seed] = stored["result"]
    return runs


def _stored(file: Path) -> Any:
    """A document of this version, as it was written."""
    try:
        text = file.read_text()
        document = json.loads(text)
        version = document["engram"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise SystemExit(f"{file}: damaged, or no result ({error})") from None
    _require_version(file, version)
    try:
        return documents.parse(text)
    except documents.DamagedError as error:
        raise SystemExit(f"{file}: {error}; remove it to start again") from None


def _require_version(file: Path, version: str) -> None:
    if version != engram.__version__:
        raise SystemExit(
            f"{file}: results of engram {version} given, of {engram.__version__} "
            "needed; remove it to start again"
        )


def _write(file: Path, document: str) -> None:
    with open_folder(file.parent) as folder:
        write_file(folder, file.name, document.encode())


# --- the CSV file: id, learner, seed, figures, version and checksum of each run ---


def _flat(result: dict[str, Any], prefix: str = "") -> dict[str, str]:
    """Figures by column; those of a nested object have its name and a dot in front."""
    cells: dict[str, str] = {}
    for key, value in result.items():
        if isinstance(value, dict):
            cells |= _flat(value, f"{prefix}{key}.")
        elif prefix or key not in KEYS:
            cells[prefix + key] = "" if value is None else str(value)
    return cells


def _nested(cells: dict[str, str]) -> dict[str, Any]:
    """The result; empty cells are None, and absent where all of an object are empty."""
    result: dict[str, Any] = {}
    for column, cell in cells.items():
        *path, key = column.split(".")
        if path and not cell:
            continue
        owner = result
        for name in path:
            owner = owner.setdefault(name, {})
        try:
            owner[key] = json.loads(cell) if cell else None
        except ValueError:
            owner[key] = cell
    return result


def _checksum(row: dict[str, str]) -> str:
    return documents.checksum_of(",".join(f"{k}={v}" for k, v in row.items() if v))


def read_runs(file: Path) -> Runs:
    """All runs of a file, which has to be of this version and as it was written."""
    runs: Runs = {}
    with file.open(newline="") as source:
        for number, row in enumerate(csv.DictReader(source), 2):
            try:
                checksum = row.pop("checksum")
                _require_version(file, row["engram"])
                if _checksum(row) != checksum:
                    raise SystemExit(
                        f"{file}:{number}: its checksum does not fit: it was edited; "
                        "remove the file to start again"
                    )
                run = (row.pop("id"), row.pop("learner"), int(row.pop("seed")))
                del row["engram"]
            except (KeyError, ValueError) as error:
                raise SystemExit(f"{file}: damaged, or no file of scores ({error})") from None
            runs[run] = _nested(row)
    return runs


def store(runs: Runs, file: Path) -> None:
    """Writes all results, a row each."""
    flat = {run: _flat(runs[run]) for run in sorted(runs)}
    figures = dict.fromkeys(column for cells in flat.values() for column in cells)
    text = io.StringIO()
    columns = ["id", "learner", "seed", *figures, "engram", "checksum"]
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    for (task, learner, seed), cells in flat.items():
        row = {"id": task, "learner": learner, "seed": str(seed)}
        row |= {column: cells.get(column, "") for column in figures}
        row["engram"] = engram.__version__
        writer.writerow({**row, "checksum": _checksum(row)})
    _write(file, text.getvalue())


# --- runs ---


def folder_of(out: Path, task: str, column: str, seed: int) -> Path:
    return out / task / f"{column}-{seed}"


def learn(command: list[str], folder: Path, task: str, seed: int) -> None:
    """Runs a learner, with its output in FOLDER/output.txt."""
    folder.mkdir(parents=True, exist_ok=True)
    options = ["--id", task, "--seed", str(seed), "--out", str(folder)]
    with (folder / "output.txt").open("w") as output:
        ended = subprocess.run([*command, *options], stdout=output, stderr=subprocess.STDOUT)
    if ended.returncode != 0:
        raise RuntimeError(f"{' '.join(command)} failed with {task}: see {folder}/output.txt")


def play(policy: Any, folder: Path, task: str, seed: int) -> None:
    """Plays one of engram's own policies."""
    batch = engram.make_vec(
        task,
        num_envs=EPISODES,
        obs_mode="none",
        threads=1,
        autoreset_mode="DISABLED",
        after_end="hold",
        terminate_on_success=False,
    )
    with contextlib.closing(batch):
        batch.reset(seed=FIRST_SEED + 1000 * (seed - 1))
        for _ in range(batch.description["horizon"]):
            infos = batch.step(batch.act(policy))[4]
    answers = infos.get("first_answer_correct")
    result = {
        "success_once": float(np.mean(infos["success_once"])),
        "first_answer_correct": None if answers is None else float(np.mean(answers)),
    }
    folder.mkdir(parents=True, exist_ok=True)
    (folder / RESULT).write_text(json.dumps(result) + "\n")


def run(args: argparse.Namespace, ids: list[str], known: Runs) -> None:
    """Runs everything without a result, the first seed of all columns first."""
    columns = args.only or [*POLICIES, *LEARNERS]

    def do(folder: Path, task: str, column: str, seed: int) -> None:
        if column in LEARNERS:
            script, *options = LEARNERS[column]
            command = [sys.executable, str(args.learners / script), *options, *args.more.split()]
            learn(command, folder, task, seed)
        else:
            play(column, folder, task, seed)

    plan = [(task, column, seed) for seed in args.seeds for column in columns for task in ids]
    complete(plan, do, known, args.out, args.jobs)


def complete(
    plan: list[Run],
    do: Callable[[Path, str, str, int], None],
    known: Runs,
    out: Path,
    jobs: int = 1,
) -> None:
    """Does the runs of a plan that are not known, in its order, and marks each that has ended.

    do: writes RESULT to a folder, for a task, column and seed.
    """

    def one(run: Run) -> None:
        folder = folder_of(out, *run)
        do(folder, *run)
        result = json.loads((folder / RESULT).read_text())
        stored = {"engram": engram.__version__, "run": run, "result": result}
        _write(folder / RUN, documents.with_checksum(json.dumps(stored)))
        task, column, seed = run
        print(f"{task} {column} {seed}: {result}", flush=True)

    missing = [run for run in plan if run not in known]
    with ThreadPoolExecutor(jobs) as pool:
        try:
            for _ in pool.map(one, missing):
                pass
        except BaseException:
            pool.shutdown(cancel_futures=True, wait=False)
            raise


# --- tables ---


def interval(rate: float, episodes: int) -> tuple[float, float]:
    """Wilson's 95 % interval of a rate."""
    z = 1.959964

    def low(rate: float) -> float:
        middle = rate + z * z / (2 * episodes)
        half = z * math.sqrt(rate * (1 - rate) / episodes + z * z / (4 * episodes**2))
        return max(0.0, (middle - half) / (1 + z * z / episodes))

    return low(rate), 1 - low(1 - rate)


def by_column(runs: Runs, ids: Iterable[str], seeds: Iterable[int]) -> dict[Column, list[Any]]:
    """Results by task and column, a list over seeds."""
    results: dict[Column, list[Any]] = {}
    for task, column, seed in itertools.product(ids, [*LEARNERS, *POLICIES], seeds):
        if (task, column, seed) in runs:
            results.setdefault((task, column), []).append(runs[task, column, seed])
    return results


def rate_cell(runs: list[Any] | None, what: str) -> str:
    """The mean over runs, its interval over all their episodes, and the worst run."""
    rates = [run[what] for run in runs or [] if run.get(what) is not None]
    if not rates:
        return "-"
    low, high = interval(statistics.fmean(rates), EPISODES * len(rates))
    worst = f"; {min(rates):.2f}" if len(rates) > 1 and min(rates) < max(rates) else ""
    return f"{statistics.fmean(rates):.3f} ({low:.2f}-{high:.2f}{worst})"


def table(head: list[str], rows: list[list[str]]) -> list[str]:
    lines = [head, ["---"] + ["---:"] * (len(head) - 1), *rows]
    return ["| " + " | ".join(line) + " |" for line in lines]


def tables(results: dict[tuple[str, str], list[Any]], ids: list[str]) -> str:
    """Markdown: success, first answers, wiped memories and processor minutes.

    Columns without any result are left out.
    """
    ran = {column for _, column in results}
    columns = [c for c in (*LEARNERS, *POLICIES) if c in ran]
    learners = [c for c in LEARNERS if c in ran]
    with_memory = [c for c in learners if c != "memoryless"]
    success = [
        [task] + [rate_cell(results.get((task, c)), "success_once") for c in columns]
        for task in ids
    ]
    answers = []
    for task in ids:
        description = engram.describe(task)
        if description.get("answer"):
            cells = [rate_cell(results.get((task, c)), "first_answer_correct") for c in columns]
            answers.append([task, f"{description['answer_chance']:.3f}", *cells])
    wiped, minutes = [], []
    for task in ids:
        cells, times = [task], [task]
        for column in learners:
            runs = results.get((task, column), [])
            if column in with_memory:
                cells.append(rate_cell([r["wiped"] for r in runs if "wiped" in r], "success_once"))
            used = [run["cpu_s"] / 60 for run in runs]
            times.append(f"{statistics.median(used):.1f}, {max(used):.1f}" if used else "-")
        wiped.append(cells)
        minutes.append(times)
    reached = []
    for column in learners:
        means = [
            statistics.fmean(r["success_once"] for r in results[t, column])
            for t in ids
            if (t, column) in results
        ]
        reached.append(f"{column} {sum(mean >= 0.9 for mean in means)} of {len(means)}")
    return "\n".join(
        [
            f"Tasks with a mean success of 0.9 or more: {', '.join(reached)}.",
            "",
            "## success_once",
            "",
            *table(["id", *columns], success),
            "",
            "## The first answer is right",
            "",
            *table(["id", "chance", *columns], answers),
            "",
            "## success_once, the memory reset whenever an object appears",
            "",
            *table(["id", *with_memory], wiped),
            "",
            "## Processor minutes of a run: median, most",
            "",
            *table(["id", *learners], minutes),
        ]
    )


def main(given: list[str] | None = None) -> int:
    args = arguments(given)
    ids = args.ids or [task["id"] for task in engram.list() if task["split"] in args.split]
    file = args.file or args.out / "scores.csv"
    if not args.tables:
        run(args, ids, known_runs(args.out, file))
    runs = known_runs(args.out, file)
    store(runs, file)
    print(tables(by_column(runs, ids, args.seeds), ids))
    return 0


if __name__ == "__main__":
    sys.exit(main())
