"""The main figures of the CSV files, in docs/data/README.md."""

import statistics

from measurements import random_draws
from measurements.common import PAGE, read_csv, section
from measurements.memory import POLICIES


def add_options(parser):
    pass


def mean(rows, column):
    values = [float(row[column]) for row in rows if row[column]]
    return f"{statistics.fmean(values):.3f}" if values else "-"


def total(rows, column):
    return sum(float(row[column]) for row in rows)


def table(head, rows):
    lines = [head, ["---"] + ["---:"] * (len(head) - 1), *rows]
    return ["| " + " | ".join(map(str, line)) + " |" for line in lines]


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


SECTIONS = {
    "memory summary": memory,
    "draws summary": draws,
    "leaks summary": lambda: steps("leak_tests.csv", "steps"),
    "perturbations summary": perturbations,
    "determinism summary": lambda: steps("determinism.csv", "env_steps"),
}


def summarised(page):
    """The page with the figures of the CSV files."""
    for name, lines in SECTIONS.items():
        page = section(page, name, lines())
    return page


def run(_):
    PAGE.write_text(summarised(PAGE.read_text()))
