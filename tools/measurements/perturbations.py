"""Success under perturbations, 200 episodes of each id or cell from the seed 4242424242.

Writes perturbations_oracle.csv and, with --agents, perturbations_students.csv.
"""

import json
import pathlib
import sys

from measurements.common import run_json, write_csv, write_section

EPISODES = 200
IMAGE_AXES = (
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


def add_options(parser):
    parser.add_argument(
        "--agents",
        type=pathlib.Path,
        metavar="DIR",
        help="students too: DIR has usual/agent.pt and robust/agent.pt of engram_learners.distil",
    )


def oracle_rates(engram, family_of, *perturb):
    """Success of the oracle by family: the least of its ids."""
    words = [engram, "eval", "--all", "--policy", "oracle", "--episodes", EPISODES, *perturb]
    families = {}
    for task in run_json(words)["tasks"]:
        family = family_of[task["env_id"]]
        families[family] = min(families.get(family, 1), task["sr"])
    return families


def write_oracle(engram):
    family_of = {task["id"]: task["family"] for task in run_json([engram, "list"])}
    cells = [(axis, level) for axis in ROBOT_AXES for level in LEVELS]
    usual = oracle_rates(engram, family_of)
    rates = [usual]
    rates += [oracle_rates(engram, family_of, "--perturb", f"{a}={level}") for a, level in cells]
    rows = [[family, *(f"{one[family]:.3f}" for one in rates)] for family in usual]
    head = ["family", "unperturbed", *(f"{axis}_{level}" for axis, level in cells)]
    write_csv("perturbations_oracle.csv", head, rows)


def agent_rate(agent, *perturb):
    words = [sys.executable, "-m", "engram_learners.evaluate", agent]
    words += ["--episodes", EPISODES, *perturb]
    return run_json(words)["policy"]["success_once"]


def write_students(agents):
    paths = [agents / "usual/agent.pt", agents / "robust/agent.pt"]
    rows = [["none", "", *(f"{agent_rate(path):.3f}" for path in paths)]]
    for axis in IMAGE_AXES + ROBOT_AXES:
        for level in LEVELS:
            rates = (agent_rate(path, "--perturb", f"{axis}={level}") for path in paths)
            rows.append([axis, level, *(f"{rate:.3f}" for rate in rates)])
    head = ["axis", "level", "usual_training", "perturbed_training"]
    write_csv("perturbations_students.csv", head, rows)
    trained = json.loads((agents / "robust/result.json").read_text())["perturb"]
    write_section("students", [f"Perturbed training: `{json.dumps(trained)}`."])


def run(options):
    write_oracle(options.engram)
    if options.agents:
        write_students(options.agents)
