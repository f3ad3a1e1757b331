"""The main figures of the CSV files, in docs/data/README.md."""

import statistics

from measurements import random_draws
from measurements.common import PAGE, read_csv, section
from measurements.memory import POLICIES

SCORES = ("success_once", "first_answer_correct", "wiped.success_once")
SPEED = ("overhead", "memory", "reset", "create", "render.cpu.128", "render.rollout")
TASK = "RememberColor9-VLA-v0"  # whose physics is shown
MEMORIES = ("none", "stack4", "gru", "lstm", "mingru", "lru", "mamba", "gtrxl", "xlstm")


def add_options(parser):
    pass


def mean(rows, column):
    values = [float(row[column]) for row in rows if row.get(column)]
    return f"{statistics.fmean(values):.3f}" if values else "-"


def total(rows, column):
    return sum(float(row[column]) for row in rows)


def table(head, rows):
    lines = [head, ["---"] + ["---:"] * (len(head) - 1), *rows]
    return ["| " + " | ".join(map(str, line)) + " |" for line in lines]


def scores():
    """A line for each learner of a file: its ids, those that it plays well, and means over ids."""
    lines = []
    for name in ("scores.csv", "scores_short.csv", "scores_long.csv"):
        runs = read_csv(name)
        for learner in dict.fromkeys(run["learner"] for run in runs):
            own = [run for run in runs if run["learner"] == learner]
            ids = dict.fromkeys(run["id"] for run in own)
            means = [mean([run for run in own if run["id"] == i], "success_once") for i in ids]
            good = sum(float(value) >= 0.9 for value in means)
            rates = (mean(own, column) for column in SCORES)
            seconds = [float(run["cpu_s"]) for run in own if run["cpu_s"]]
            minutes = f"{statistics.median(seconds) / 60:.1f}" if seconds else "-"
            lines.append([f"{name}, {learner}", len(ids), good, *rates, minutes])
    head = ["", "ids", "with 0.9 or more", *SCORES, "processor minutes, median"]
    return table(head, lines)


def memories():
    """A line for each memory: success in the short and in the Long task, by learner and task."""
    runs = read_csv("memories.csv")
    groups = dict.fromkeys((run["learner"].split("_")[0], run["id"]) for run in runs)
    cells = {}
    for learner, task in groups:
        long = f"transfer.{task.removesuffix('-VLA-v0')}-Long-VLA-v0.success_once"
        for name in MEMORIES:
            own = [r for r in runs if (r["learner"], r["id"]) == (f"{learner}_{name}", task)]
            rates = f"{mean(own, 'success_once')} / {mean(own, long)}" if own else "-"
            cells[name, learner, task] = mean(own, "mean_return") if learner == "popgym" else rates
    head = ["memory", *(f"{learner}, {task.removesuffix('-VLA-v0')}" for learner, task in groups)]
    lines = [[name, *(cells[(name, *group)] for group in groups)] for name in MEMORIES]
    sizes = {run["memory"]: f"{int(run['parameters']):,}" for run in runs}
    return table([*head, "parameters"], [[*line, sizes[line[0]]] for line in lines])


def memory():
    """Means over ids, of the VLA tasks and the RL tasks."""
    rows = read_csv("memory.csv")
    groups = {"VLA": [row for row in rows if "-VLA-" in row["id"]]}
    groups["RL"] = [row for row in rows if "-VLA-" not in row["id"]]
    columns = ["chance", *POLICIES, *(f"{policy}_strict" for policy in POLICIES)]
    lines = [
        [f"{n}, {len(own)} ids", *(mean(own, c) for c in columns)] for n, own in groups.items()
    ]
    return table(["mean over ids", *columns], lines)


def draws():
    rows = read_csv("random_draws.csv")
    chi, dof = total(rows, "chi2"), total(rows, "dof")
    p = random_draws.tail(chi, dof)
    return [f"All {len(rows)} ids: chi2 {chi:.1f} with {dof:.0f} degrees of freedom, p = {p:.3f}."]


def steps(name, column):
    rows = read_csv(name)
    compared = f"{total(rows, column):,.0f}"
    return [f"{compared} steps compared, {total(rows, 'different'):.0f} different."]


def perturbations():
    rows = read_csv("perturbations_oracle.csv")
    columns = [column for column in rows[0] if column != "family"]
    return table(["", *columns], [["mean over families", *(mean(rows, c) for c in columns)]])


def speed():
    """The whole engine, and one task of the suites that have several."""
    rows = read_csv("speed.csv")
    shown = [r for r in rows if r["name"] in SPEED or r["name"].startswith(f"physics.{TASK}.")]
    columns = ("value", "unit", "baseline", "baseline_value", "ratio")
    lines = [[f"`{r['suite']}`", r["name"], *(r[column] for column in columns)] for r in shown]
    return table(["suite", "name", *columns], lines)


SECTIONS = {
    "scores summary": scores,
    "memories summary": memories,
    "memory summary": memory,
    "draws summary": draws,
    "leaks summary": lambda: steps("leak_tests.csv", "steps"),
    "perturbations summary": perturbations,
    "speed summary": speed,
    "determinism summary": lambda: steps("determinism.csv", "env_steps"),
}


def summarised(page):
    """The page with the figures of the CSV files."""
    for name, lines in SECTIONS.items():
        page = section(page, name, lines())
    return page


def run(_):
    PAGE.write_text(summarised(PAGE.read_text()))
