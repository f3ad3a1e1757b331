"""Checks that the files of docs/data agree with one another and with the engram command."""

import re
import sys

from measurements import summary, variants
from measurements.common import PAGE, rate, read_csv, run_json
from measurements.memory import FIGURES, POLICIES

TASK = "RememberColor3-VLA-v0"  # played again for its fingerprints


def add_options(parser):
    pass


def stale_summary(_):
    page = PAGE.read_text()
    if summary.summarised(page) != page:
        yield "README.md: its figures are stale; renew them with: tools/measure.py summary"


def stale_rates(_):
    """Ids whose rates are not those that the command goes by."""
    columns = [*POLICIES, *(f"{policy}_answer" for policy in POLICIES)]
    rows = {row["id"]: [row[column] for column in columns] for row in read_csv("memory.csv")}
    known = {}
    for task, values in re.findall(
        r'^    \{"([\w-]+)", (.*)\},$', FIGURES.read_text(), re.MULTILINE
    ):
        known[task] = [
            rate(None if value == "-1" else float(value)) for value in values.split(", ")
        ]
    for task in rows.keys() | known.keys():
        if rows.get(task) != known.get(task):
            yield f"memory.csv: {task}: {rows.get(task)}; {known.get(task)} in {FIGURES.name}"


def stale_constants(engram):
    rows = [tuple(row.values()) for row in read_csv("constants.csv")]
    for row in set(rows) ^ set(variants.constants(engram)):
        yield f"constants.csv: {row}; renew it with: tools/measure.py variants"


def stale_bits(engram):
    row = next(row for row in read_csv("determinism.csv") if row["id"] == TASK)
    for played in run_json([engram, "verify", TASK]):
        if played["fingerprint"] != row[played["obs"]]:
            yield f"determinism.csv: {TASK} {played['obs']}: {played['fingerprint']} played"


def run(options):
    checks = (stale_summary, stale_rates, stale_constants, stale_bits)
    problems = [problem for check in checks for problem in check(options.engram)]
    sys.exit("\n".join(problems) or 0)
