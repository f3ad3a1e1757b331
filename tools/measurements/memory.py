"""Success of policies without memory, and of the oracle.

Writes memory.csv, random_draws.csv and the figures that `engram info` and the scores of
`engram eval` go by; build again afterwards.
"""

import json
import pathlib
import time

from measurements import random_draws
from measurements.common import (
    ROOT,
    between,
    rate,
    read_csv,
    run_json,
    write_csv,
    write_section,
)

POLICIES = ("blind", "sweep", "oracle")
EPISODES = 200
SEED = 1000
CANONICAL_EPISODES = 50
CANONICAL_SEED = 4242424242
STRICT = ("--option", "strict=1")
POSE = ("--control-mode", "pd_ee_delta_pose")
COLUMNS = (
    ["id", "chance", *POLICIES, "answer_chance"]
    + [f"{policy}_answer" for policy in POLICIES]
    + [f"{policy}_strict" for policy in POLICIES]
    + ["oracle_pose"]
)
FIGURES = ROOT / "protocol" / "make" / "baseline_scores.cc"


def add_options(parser):
    parser.add_argument("--rl", action="store_true", help="the RL tasks alone, a few minutes")
    parser.add_argument(
        "--measured",
        type=pathlib.Path,
        metavar="FILE",
        help="keeps what was measured; where it exists, the files are written from it",
    )


class Evaluator:
    """`engram eval`, with a list of the commands."""

    def __init__(self, command):
        self.command = command
        self.commands = []

    def evaluate(self, tasks, policy, episodes, seed, *more):
        """Results by id. tasks: "--all", "--split" and a split, or ids."""
        options = ["--policy", policy, "--episodes", str(episodes), "--seed", str(seed), *more]
        shown = tasks if tasks[0].startswith("--") else ["ID..."]
        self.commands.append(" ".join(["engram eval", *shown, *options]))
        found = run_json([self.command, "eval", *tasks, *options])["tasks"]
        return {task["env_id"]: task for task in found}


def measure(command, rl):
    start = time.monotonic()
    engram = Evaluator(command)
    tasks = ["--split", "rl"] if rl else ["--all"]
    results = {p: engram.evaluate(tasks, p, EPISODES, SEED) for p in POLICIES}
    answered = [i for i, task in results["oracle"].items() if task["first_answers"] is not None]
    strict = {p: engram.evaluate(answered, p, EPISODES, SEED, *STRICT) for p in POLICIES}
    measured = {"results": results, "strict": strict}
    if rl:
        measured["pose"] = engram.evaluate(tasks, "oracle", EPISODES, SEED, *POSE)
    else:
        canonical = (CANONICAL_EPISODES, CANONICAL_SEED)
        measured["canonical"] = engram.evaluate(tasks, "oracle", *canonical)
        measured["info"] = {i: run_json([command, "info", i]) for i in results["oracle"]}
    minutes = (time.monotonic() - start) / 60
    return {**measured, "minutes": minutes, "commands": engram.commands}


def rows_of(measured):
    rows = []
    for name in measured["results"]["oracle"]:
        of = [measured["results"][policy][name] for policy in POLICIES]
        strict = [measured["strict"][policy].get(name, {}).get("sr") for policy in POLICIES]
        pose = measured.get("pose", {}).get(name, {}).get("sr")
        values = [of[0]["chance"], *(task["sr"] for task in of), of[0]["answer_chance"]]
        values += [*(task["first_answer_correct"] for task in of), *strict, pose]
        rows.append([name, *map(rate, values)])
    return rows


def figures(results):
    """Rows of C++ with the rates that `engram info` goes by."""
    lines = []
    for name in results["oracle"]:
        of = [results[policy][name] for policy in POLICIES]
        answers = (task["first_answer_correct"] for task in of)
        values = [*(task["sr"] for task in of), *(-1 if a is None else a for a in answers)]
        lines.append(f'    {{"{name}", ' + ", ".join(f"{value:g}" for value in values) + "},")
    return "\n".join(lines)


def run(options):
    name = "memory_rl" if options.rl else "memory"
    file = options.measured or ROOT / "build" / f"{name}.json"
    if not file.exists():
        file.write_text(json.dumps(measure(options.engram, options.rl)))
    measured = json.loads(file.read_text())
    results = measured["results"]
    old = [[row[column] for column in COLUMNS] for row in read_csv("memory.csv")]
    others = [row for row in old if row[0] not in results["oracle"]]
    own = rows_of(measured)
    write_csv("memory.csv", COLUMNS, others + own if options.rl else own + others)
    mark = "rl" if options.rl else "vla"
    begin = f"    // begin {mark}: written by tools/measure.py memory"
    text = between(FIGURES.read_text(), begin, f"    // end {mark}", figures(results))
    FIGURES.write_text(text)
    if not options.rl:
        random_draws.write(measured["canonical"], measured["info"])
    text = f"In {measured['minutes']:.0f} minutes, with these commands:"
    write_section(name, [text, "", "```sh", *measured["commands"], "```"])
