"""Checks that the files of docs/data agree with one another and with the engram command."""

import sys

from measurements import summary, variants
from measurements.common import PAGE, read_csv, run_json

TASK = "RememberColor3-VLA-v0"  # played again for its fingerprints


def add_options(parser):
    pass


def stale_summary(_):
    page = PAGE.read_text()
    if summary.summarised(page) != page:
        yield "README.md: its figures are stale; renew them with: tools/measure.py summary"


def stale_rates(engram):
    """Ids whose rates are not those that the command goes by."""
    rows = {row["id"]: row for row in read_csv("memory.csv")}
    ids = [task["id"] for task in run_json([engram, "list"])]
    if sorted(ids) != sorted(rows):
        yield "memory.csv: its ids are not those of `engram list`"
    for task in set(ids) & set(rows):
        for policy, known in run_json([engram, "info", task])["ceilings"].items():
            columns = {policy: "success_once", f"{policy}_answer": "first_answer_correct"}
            for column, field in columns.items():
                value, expected = rows[task][column], known[field]
                text = "" if expected is None else f"{expected:.3f}"
                if value != text:
                    yield f"memory.csv: {task} {column}: {expected} in `engram info`"


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
