"""Constants of all families, and the oracle's success with the values of tests/data/variants.

Writes constants.csv and tried_values.csv.
"""

import json

from measurements.common import ROOT, run_json, write_csv

TRIED = ROOT / "tests" / "data" / "variants"
EPISODES = 20
CONSTANT_COLUMNS = ["families", "constant", "value", "allowed", "unit", "description"]
# Every family has them; docs/variants.md says so.
COMMON = ("max_episode_steps", "robot_init_qpos_noise", "robot_uids")


def add_options(parser):
    pass


def in_words(value):
    if isinstance(value, list):
        return ", ".join(in_words(one) for one in value)
    return f"{value:g}" if isinstance(value, float) else str(value)


def bounds(constant):
    if constant["kind"] == "name":
        return "one of " + ", ".join(constant["names"])
    low, high = f"{constant['low']:.7g}", f"{constant['high']:.7g}"
    if constant["kind"] in ("names", "colors"):
        others = ", or red, green and blue" if constant["kind"] == "colors" else ""
        return f"{low} to {high} of " + ", ".join(constant["names"]) + others
    return f"{low} to {high}"


def constants(engram):
    """Rows of constants.csv: one per constant; families with the same row share it."""
    rows = {}
    first_ids = {}
    for task in run_json([engram, "list"]):
        first_ids.setdefault(task["family"], task["id"])
    for family, task_id in first_ids.items():
        for constant in run_json([engram, "info", task_id])["changeable"]:
            if constant["name"] not in COMMON:
                cells = (constant["name"], in_words(constant["value"]), bounds(constant))
                cells += (constant["unit"], constant["description"])
                rows.setdefault(cells, []).append(family)
    return sorted((", ".join(families), *cells) for cells, families in rows.items())


def setting(name, value):
    values = value if isinstance(value, list) else [value]
    if any(isinstance(one, list) for one in values):
        return f"{name}={json.dumps(value)}"
    return f"{name}={','.join(map(str, values))}"


def write_tried(engram):
    rows = []
    for file in sorted(TRIED.glob("*.csv")):
        for line in file.read_text().splitlines():
            if not line or line.startswith("#"):
                continue
            task, text, _, note = line.split(";", 3)
            settings = [setting(*item) for item in json.loads(text).items()]
            words = [engram, "eval", task, *(w for one in settings for w in ("--set", one))]
            result = run_json([*words, "--policy", "oracle", "--episodes", EPISODES])
            rows.append([task, " ".join(settings), f"{result['tasks'][0]['sr']:.2f}", note])
    write_csv("tried_values.csv", ["id", "constants", "oracle", "note"], rows)


def run(options):
    write_csv("constants.csv", CONSTANT_COLUMNS, constants(options.engram))
    write_tried(options.engram)
