"""Compares the nine memories: each learns each task from several seeds, and plays its longer form.

    python -m engram_learners.zoo.scores  # runs what is missing, prints the tables
    python -m engram_learners.zoo.scores --learners imitation --seeds 1 --memories gru lru
    python -m engram_learners.zoo.scores --learners popgym  # in POPGym's tasks, which needs popgym

Every run is a process of its own; the command can be stopped at any time and continues there.
Results are stored under --out and in a CSV file, like those of engram_learners.scores.
"""

import argparse
import os
import statistics
import sys
from pathlib import Path

import engram
from engram_learners import memories, scores

LEARNERS = ("imitation", "ppo", "popgym")  # modules of engram_learners.zoo
LONGER = {
    "RememberColor3-VLA-v0": "RememberColor3-Long-VLA-v0",
    "RememberColor9-VLA-v0": "RememberColor9-Long-VLA-v0",
    "ShellGameShuffleTouch-VLA-v0": "ShellGameShuffleTouch-Long-VLA-v0",
}
POPGYM = ["RepeatPreviousEasy", "AutoencodeEasy"]


def arguments(given):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("--ids", nargs="+", metavar="ID", help="default: all tasks of these learners")
    add("--memories", nargs="+", default=list(memories.MEMORIES), choices=list(memories.MEMORIES))
    add("--learners", nargs="+", default=["imitation", "ppo"], choices=LEARNERS)
    add("--seeds", type=int, nargs="+", default=[1, 2, 3])
    add("--out", type=Path, default=Path("build/memories"), help="folder of the runs")
    add("--file", type=Path, help="CSV file of all runs; default: OUT/memories.csv")
    add("--jobs", type=int, default=os.cpu_count() or 1, help="runs at the same time")
    add("--tables", action="store_true", help="runs nothing; prints the tables of existing runs")
    add("--pass", dest="more", default="", metavar="'...'", help="further options for learners")
    args = parser.parse_args(given)
    allowed = [task for learner in args.learners for task in tasks_of(learner)]
    unplayed = [task for task in args.ids or [] if task not in allowed]
    if unplayed:
        learners, tasks = " ".join(args.learners), ", ".join(dict.fromkeys(allowed))
        parser.error(f"--ids {' '.join(unplayed)} given; tasks of --learners {learners}: {tasks}")
    return args


def column_of(learner, memory):
    return f"{learner}_{memory}"


def tasks_of(learner):
    return POPGYM if learner == "popgym" else list(LONGER)


def run(args, known):
    def do(folder, task, column, seed):
        learner, memory = column.split("_")
        command = [sys.executable, "-m", f"engram_learners.zoo.{learner}", "--memory", memory]
        test = ["--test", LONGER[task]] if task in LONGER else []
        scores.learn([*command, *test, *args.more.split()], folder, task, seed)

    plan = [
        (task, column_of(learner, memory), seed)
        for learner in args.learners
        for task in tasks_of(learner)
        if task in (args.ids or [task])
        for seed in args.seeds
        for memory in args.memories
    ]
    scores.complete(plan, do, known, args.out, args.jobs)


def of_memories(runs, learner, task):
    """Results over seeds, by memory, of those that have some."""
    for memory in memories.MEMORIES:
        run = (task, column_of(learner, memory))
        own = [result for key, result in sorted(runs.items()) if key[:2] == run]
        if own:
            yield memory, own


def cost_cell(own):
    return f"{statistics.median(result['cpu_s_per_million_steps'] for result in own):,.0f}"


def popgym_table(runs, task):
    """Markdown: a row for each memory, over its seeds."""
    rows = []
    for memory, own in of_memories(runs, "popgym", task):
        returns = [result["mean_return"] for result in own]
        cells = [statistics.fmean(returns), min(returns), max(r["best_mean_return"] for r in own)]
        steps = max(result["env_steps"] for result in own)
        cells = [f"{cell:.3f}" for cell in cells]
        rows.append([memory, str(len(own)), *cells, f"{steps:,}", cost_cell(own)])
    if not rows:
        return []
    head = ["memory", "seeds", "return", "worst seed", "best on the way", "steps", "cpu s"]
    return [f"## PPO, POPGym's {task}", "", *scores.table(head, rows), ""]


def table(runs, learner, task):
    """Markdown: a row for each memory, over its seeds."""
    rows = []
    for memory, own in of_memories(runs, learner, task):
        reset = [result["wiped"] for result in own if "wiped" in result]
        far = [result["transfer"][LONGER[task]] for result in own]
        cells = [
            scores.rate_cell(part, figure)
            for part, figure in (
                (own, "success_once"),
                (reset, "success_once"),
                (far, "success_once"),
                (far, "first_answer_correct"),
            )
        ]
        rows.append([memory, str(len(own)), *cells, cost_cell(own)])
    if not rows:
        return []
    head = ["memory", "seeds", "short", "short, reset", "Long", "Long, first answer", "cpu s"]
    title = f"## {learner}, {task}"
    chance = f"Chance of an answer: {engram.describe(task)['answer_chance']:.3f}."
    return [title, "", chance, "", *scores.table(head, rows), ""]


def sizes(runs):
    """Markdown: the parameters of each memory in these runs."""
    rows = []
    for memory in memories.MEMORIES:
        counts = {run["parameters"] for run in runs.values() if run["memory"] == memory}
        if counts:
            rows.append([memory, ", ".join(f"{count:,}" for count in sorted(counts))])
    return ["## Parameters", "", *scores.table(["memory", "parameters"], rows)]


def tables(runs):
    lines = []
    for learner in LEARNERS:
        for task in tasks_of(learner):
            popgym = learner == "popgym"
            lines += popgym_table(runs, task) if popgym else table(runs, learner, task)
    return "\n".join([*lines, *sizes(runs)])


def main(given=None):
    args = arguments(given)
    file = args.file or args.out / "memories.csv"
    if not args.tables:
        run(args, scores.known_runs(args.out, file))
    runs = scores.known_runs(args.out, file)
    scores.store(runs, file)
    print(tables(runs))
    return 0


if __name__ == "__main__":
    sys.exit(main())
