#!/usr/bin/env python3
"""Measures policies under perturbations and writes docs/data/perturbations.md.

perturbations.py --engram build/release/engram [--agents DIR]
    DIR has usual/agent.pt and robust/agent.pt of python/examples/memory/distil.py; it runs their
    evaluate.py, so it needs the Python package and torch. Without DIR the students' part of the
    page stays as it is.
"""

import argparse
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "data" / "perturbations.md"
EPISODES = 200  # of each id for the oracle, of each cell for students
PICTURE_AXES = (
    "camera",
    "fov",
    "light",
    "table",
    "floor",
    "distractors",
    "occluder",
    "noise",
    "blur",
)
ROBOT_AXES = ("start_pose", "action_delay", "action_noise")
LEVELS = (0.5, 1)

HEAD = """# Policies under perturbations

`scripts/perturbations.py` writes this page; [perturbations](../perturbations.md) explains the axes.
Rates of success once, from the seed 4242424242: {episodes} episodes of each id for the oracle, and
of every cell for students.
"""
STUDENTS = "\n## Students from pictures\n"


def run(words):
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, words))}: {done.stderr.strip()}")
    return done.stdout


def oracle_rates(engram, axis=None, level=None):
    """Success of the oracle by family: the least of its ids."""
    words = [engram, "eval", "--all", "--policy", "oracle", "--episodes", str(EPISODES)]
    words += ["--json"] if axis is None else ["--json", "--perturb", f"{axis}={level}"]
    families = {}
    known = {entry["id"]: entry for entry in json.loads(run([engram, "list", "--json"]))}
    for task in json.loads(run(words))["tasks"]:
        family = known[task["env_id"]]["family"]
        families[family] = min(families.get(family, 1), task["sr"])
    return families


def agent_rate(agent, perturb=()):
    words = [sys.executable, ROOT / "python/examples/memory/evaluate.py", agent, "--json"]
    words += ["--episodes", str(EPISODES)]
    words += ["--perturb", *perturb] if perturb else []
    return json.loads(run(words))["policy"]["success_once"]


def table(head, rows):
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def oracle_table(engram):
    columns = [(axis, level) for axis in ROBOT_AXES for level in LEVELS]
    usual = oracle_rates(engram)
    rates = [oracle_rates(engram, *column) for column in columns]
    rows = [
        [family, f"{usual[family]:.3f}", *(f"{one[family]:.3f}" for one in rates)]
        for family in usual
    ]
    return table(["family", "usual", *(f"{axis} {level}" for axis, level in columns)], rows)


def agents_table(agents):
    paths = [agents / "usual/agent.pt", agents / "robust/agent.pt"]
    rows = [["none", "", *(f"{agent_rate(path):.3f}" for path in paths)]]
    for axis in PICTURE_AXES + ROBOT_AXES:
        for level in LEVELS:
            rates = (agent_rate(path, [f"{axis}={level}"]) for path in paths)
            rows.append([f"`{axis}`", str(level), *(f"{rate:.3f}" for rate in rates)])
    return table(["axis", "level", "usual training", "perturbed training"], rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--engram", default="build/release/engram")
    parser.add_argument("--agents", type=pathlib.Path)
    options = parser.parse_args()
    if options.agents is None:
        students = PAGE.read_text().partition(STUDENTS)[2]
    else:
        trained = json.loads((options.agents / "robust/result.json").read_text())
        students = (
            "\nRememberColor3, `distil.py --obs rgb` with and without `--perturb` "
            f"({json.dumps(trained.get('perturb'))}).\n\n{agents_table(options.agents)}\n"
        )
    PAGE.write_text(
        HEAD.format(episodes=EPISODES)
        + "\n## The oracle\n\nThe least rate of a family's ids. What cameras see makes no "
        f"difference to it.\n\n{oracle_table(options.engram)}\n{STUDENTS}{students}"
    )


if __name__ == "__main__":
    main()
