#!/usr/bin/env python3
"""Writes the tables of docs/data/variants.md.

They are the constants that users change, from `engram info ID --json`, and what the oracle makes of
the values in tests/data/variants, from `engram eval`.

The page marks each table: <!-- constants --> or <!-- tried -->, then <!-- end -->.
"""

import argparse
import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "data" / "variants.md"
TRIED = ROOT / "tests" / "data" / "variants"
EPISODES = 20
# Every family has them; the page says so.
COMMON = ("max_episode_steps", "robot_init_qpos_noise", "robot_uids")


def ask(command, *arguments):
    done = subprocess.run([command, *arguments], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{command} {' '.join(arguments)}: {done.stderr.strip()}")
    return json.loads(done.stdout)


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


def constants_table(engram):
    """One row per constant and family; families with the same row share it."""
    rows = {}
    seen = set()
    for entry in ask(engram, "list", "--json"):
        if entry["family"] in seen:
            continue
        seen.add(entry["family"])
        for constant in ask(engram, "info", entry["id"], "--json")["changeable"]:
            if constant["name"] in COMMON:
                continue
            cells = (
                f"`{constant['name']}`",
                in_words(constant["value"]),
                bounds(constant),
                constant["unit"],
                constant["description"],
            )
            rows.setdefault(cells, []).append(entry["family"])
    lines = [
        "| families | constant | value | allowed | unit | |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for cells, families in sorted(rows.items(), key=lambda row: (row[1], row[0])):
        lines.append("| " + " | ".join((", ".join(families), *cells)) + " |")
    return lines


def tried_table(engram):
    lines = ["| id | constants | oracle | |", "| --- | --- | ---: | --- |"]
    for file in sorted(TRIED.glob("*.csv")):
        for line in file.read_text().splitlines():
            if not line or line.startswith("#"):
                continue
            id_, text, _, note = line.split(";", 3)
            settings = []
            for name, value in json.loads(text).items():
                values = value if isinstance(value, list) else [value]
                if any(isinstance(one, list) for one in values):
                    settings.append(f"{name}={json.dumps(value)}")
                else:
                    settings.append(f"{name}={','.join(str(one) for one in values)}")
            sets = [word for setting in settings for word in ("--set", setting)]
            result = ask(
                engram,
                "eval",
                id_,
                *sets,
                "--policy",
                "oracle",
                "--episodes",
                str(EPISODES),
                "--json",
            )
            rate = result["tasks"][0]["sr"]
            lines.append(f"| {id_} | `{' '.join(settings)}` | {rate:.2f} | {note} |")
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--engram", default=str(ROOT / "build" / "release" / "engram"))
    engram = parser.parse_args().engram
    page = PAGE.read_text()
    for mark, lines in (
        ("constants", constants_table(engram)),
        ("tried", tried_table(engram)),
    ):
        pattern = re.compile(rf"(<!-- {mark} -->\n).*?(<!-- end -->)", re.DOTALL)
        text = "\n".join(lines)
        page = pattern.sub(
            lambda found, text=text: f"{found[1]}\n{text}\n\n{found[2]}", page, count=1
        )
    PAGE.write_text(page)


if __name__ == "__main__":
    main()
