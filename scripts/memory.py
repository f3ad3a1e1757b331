#!/usr/bin/env python3
"""Measures what policies without memory achieve, and writes it down.

That is, the tables of docs/data/memory.md and the figures in protocol/make/ceilings.cc, which
`engram info` and the scores of `engram eval` go by. Build again afterwards.

memory.py [--engram COMMAND] [--measured FILE]    about a quarter of an hour on two cores
memory.py --rl                                    the RL tasks alone, a few minutes

FILE keeps what was measured: where it is there, the tables are written from it.
"""

import argparse
import collections
import json
import math
import pathlib
import re
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "data" / "memory.md"
FIGURES = ROOT / "protocol" / "batch" / "ceilings.cc"
POLICIES = ("blind", "sweep", "oracle")
EPISODES = 200
SEED = 1000
CANONICAL_EPISODES = 50
COLORS = 9  # of the families with coloured cubes
CANONICAL_SEED = 4242424242


class Engram:
    """The command, with a list of what was asked of it."""

    def __init__(self, command):
        self.command = command
        self.asked = []

    def __call__(self, *arguments, note=True):
        if note:
            self.asked.append("engram " + " ".join(arguments))
        done = subprocess.run(
            [self.command, *arguments, "--json"],
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode != 0:
            sys.exit(f"{self.command} {' '.join(arguments)}: {done.stderr.strip()}")
        return json.loads(done.stdout)

    def evaluate(self, ids, policy, episodes, seed, *more):
        """Results by id."""
        which = ("--all",) if ids is None else ids
        of_half = ids is None or ids == RL
        shown = (
            *which,
            "--policy",
            policy,
            "--episodes",
            str(episodes),
            "--seed",
            str(seed),
            *more,
        )
        if of_half:
            tasks = self("eval", *shown)["tasks"]
        else:
            self.asked.append("engram eval ID... " + " ".join(shown[len(ids) :]))
            tasks = self("eval", *shown, note=False)["tasks"]
        return {task["env_id"]: task for task in tasks}


# --- tables ---


def share(value):
    return "-" if value is None else f"{value:.3f}"


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "| --- |" + " ---: |" * (len(head) - 1)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def ceilings_table(results, ids):
    head = [
        "id",
        "chance",
        *POLICIES,
        "answer: chance",
        *(f"answer: {p}" for p in POLICIES),
    ]
    rows = []
    for name in ids:
        of = [results[policy][name] for policy in POLICIES]
        rows.append(
            [
                f"`{name}`",
                share(of[0]["chance"]),
                *(share(one["sr"]) for one in of),
                share(of[0]["answer_chance"]),
                *(share(one["first_answer_correct"]) for one in of),
            ]
        )
    return table(head, rows)


def strict_table(strict):
    head = ["id", "chance of an answer", *POLICIES]
    rows = []
    for name, one in strict["oracle"].items():
        rates = [share(strict[policy][name]["sr"]) for policy in POLICIES]
        rows.append([f"`{name}`", share(one["answer_chance"]), *rates])
    return table(head, rows)


# --- independence ---


def tail(chi, freedom):
    """Probability of at least this chi-squared (Wilson and Hilferty's approximation)."""
    spread = 2 / (9 * freedom)
    return 0.5 * math.erfc(((chi / freedom) ** (1 / 3) - 1 + spread) / math.sqrt(2 * spread))


def luckiest(numbers, members, episodes):
    """Occurrences of the most frequent number that luck exceeds in one of a hundred tasks."""
    share = members / numbers
    above = 0.0
    for hits in range(episodes, -1, -1):
        above += math.comb(episodes, hits) * share**hits * (1 - share) ** (episodes - hits)
        if above * numbers > 0.01:
            return hits + 1
    return 0


def hidden_numbers(name, task, about):
    """How many numbers there are to choose from, and those of every episode.

    The latter as lists: one, or of the coloured cubes a set. Nothing where answers are not equally
    likely.
    """
    pairs = zip(task["first_answers"] or [], task["first_answers_correct"] or [])
    answers = [answer for answer, right in pairs if right]
    if "OfColors" in name:  # a digit per touch, 1 + the colour
        return COLORS, [[int(digit) for digit in str(answer)] for answer in answers]
    candidates = about["candidates"]
    if not answers or not about["equal_answers"] or not 2 <= candidates <= CANONICAL_EPISODES:
        return None
    return candidates, [[answer] for answer in answers]


def independence(canonical, info):
    """A row per task, and their sum.

    Chi-squared of memberships is the usual one where there is one number per episode.
    """
    rows, chi_sum, freedom_sum = [], 0.0, 0
    for name, task in canonical.items():
        hidden = hidden_numbers(name, task, info[name])
        if hidden is None:
            continue
        numbers, episodes = hidden
        members = len(episodes[0])
        counts = collections.Counter(number for episode in episodes for number in episode)
        expected = len(episodes) * members / numbers
        squares = sum((count - expected) ** 2 for count in counts.values())
        squares += (numbers - len(counts)) * expected**2
        chi = squares / (expected * (1 - members / numbers)) * (numbers - 1) / numbers
        chi_sum += chi
        freedom_sum += numbers - 1
        rows.append(
            [
                f"`{name}`",
                f"{members} of {numbers}",
                str(len(episodes)),
                str(max(counts.values())),
                str(luckiest(numbers, members, len(episodes))),
                f"{chi:.2f}",
                str(numbers - 1),
                f"{tail(chi, numbers - 1):.3f}",
            ]
        )
    total = [f"all {len(rows)}", "", "", "", "", f"{chi_sum:.1f}", str(freedom_sum)]
    rows.append([*total, f"{tail(chi_sum, freedom_sum):.3f}"])
    head = [
        "id",
        "hidden",
        "episodes",
        "most frequent",
        "luck's limit",
        "chi2",
        "dof",
        "p",
    ]
    return table(head, rows)


# --- files ---


def put(text, name, content, begin="<!-- {} -->", end="<!-- end -->"):
    pattern = re.escape(begin.format(name)) + ".*?" + re.escape(end)
    whole = f"{begin.format(name)}\n{content}\n{end}"
    if not re.search(pattern, text, re.DOTALL):
        sys.exit(f"no place for '{name}'")
    return re.sub(pattern, lambda _: whole, text, count=1, flags=re.DOTALL)


def figures(array, results, ids):
    lines = [f"constexpr Ceiling {array}[] = {{"]
    for name in ids:
        rates = [results[policy][name]["sr"] for policy in POLICIES]
        answers = [results[policy][name]["first_answer_correct"] for policy in POLICIES]
        values = [*rates, *(-1 if answer is None else answer for answer in answers)]
        lines.append(f'    {{"{name}", ' + ", ".join(f"{value:g}" for value in values) + "},")
    return "\n".join([*lines, "};"])


def measure(engram):
    start = time.monotonic()
    results = {p: engram.evaluate(None, p, EPISODES, SEED) for p in POLICIES}
    ids = list(results["oracle"])
    asked = [name for name in ids if results["oracle"][name]["first_answers"] is not None]
    option = ("--option", "strict=1")
    strict = {p: engram.evaluate(asked, p, EPISODES, SEED, *option) for p in POLICIES}
    canonical = engram.evaluate(None, "oracle", CANONICAL_EPISODES, CANONICAL_SEED)
    info = {}
    for name in ids:
        about = engram("info", name, note=False)
        chance = about["answer_chance"] or 0
        about["equal_answers"] = abs(chance * about["candidates"] - 1) < 1e-9
        info[name] = about
    return {
        "minutes": (time.monotonic() - start) / 60,
        "commands": engram.asked,
        "results": results,
        "strict": strict,
        "canonical": canonical,
        "info": info,
    }


def write(measured):
    results, ids = measured["results"], list(measured["results"]["oracle"])
    made = f"Made by `scripts/memory.py` in {measured['minutes']:.0f} minutes, with these commands:"
    commands = "\n".join(measured["commands"])
    page = PAGE.read_text()
    page = put(page, "made", f"{made}\n\n```sh\n{commands}\n```")
    page = put(page, "ceilings", ceilings_table(results, ids))
    page = put(page, "strict", strict_table(measured["strict"]))
    page = put(page, "independence", independence(measured["canonical"], measured["info"]))
    PAGE.write_text(page)
    put_figures("ceilings", figures("kCeilings", results, ids))


def put_figures(name, content):
    FIGURES.write_text(put(FIGURES.read_text(), name, content, *MARKS))


def measure_rl(engram):
    start = time.monotonic()
    results = {p: engram.evaluate(RL, p, EPISODES, SEED) for p in POLICIES}
    asked = [name for name, task in results["oracle"].items() if task["first_answers"] is not None]
    strict = {
        p: engram.evaluate(asked, p, EPISODES, SEED, "--option", "strict=1") for p in POLICIES
    }
    pose = engram.evaluate(RL, "oracle", EPISODES, SEED, "--control-mode", "pd_ee_delta_pose")
    return {
        "minutes": (time.monotonic() - start) / 60,
        "commands": engram.asked,
        "results": results,
        "strict": strict,
        "pose": pose,
    }


def rl_table(measured):
    results = measured["results"]
    head = ["id", "chance", *POLICIES, "oracle, pd_ee_delta_pose"]
    head += [f"answer: {policy}" for policy in POLICIES] + [
        f"strict: {policy}" for policy in POLICIES
    ]
    rows = []
    for name, oracle in results["oracle"].items():
        of = [results[policy][name] for policy in POLICIES]
        strict = [measured["strict"][policy].get(name, {}).get("sr") for policy in POLICIES]
        rates = [oracle["chance"], *(one["sr"] for one in of), measured["pose"][name]["sr"]]
        answers = [one["first_answer_correct"] for one in of]
        rows.append([f"`{name}`", *map(share, [*rates, *answers, *strict])])
    return table(head, rows)


def write_rl(measured):
    minutes = f"{measured['minutes']:.0f} minutes"
    made = f"Made by `scripts/memory.py --rl` in {minutes}, with these commands:"
    commands = "\n".join(measured["commands"])
    page = put(PAGE.read_text(), "rl made", f"{made}\n\n```sh\n{commands}\n```")
    PAGE.write_text(put(page, "rl", rl_table(measured)))
    results = measured["results"]
    put_figures("rl ceilings", figures("kRlCeilings", results, list(results["oracle"])))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--engram", default=str(ROOT / "build" / "release" / "engram"))
    parser.add_argument("--measured", type=pathlib.Path, help="default: build/memory.json")
    parser.add_argument("--rl", action="store_true", help="the RL tasks alone")
    arguments = parser.parse_args()
    which = (measure_rl, write_rl) if arguments.rl else (measure, write)
    file = arguments.measured or ROOT / "build" / (
        "memory_rl.json" if arguments.rl else "memory.json"
    )
    if not file.exists():
        file.write_text(json.dumps(which[0](Engram(arguments.engram))))
    which[1](json.loads(file.read_text()))


MARKS = ("// begin {}: written by scripts/memory.py", "// end ceilings")
RL = ("--split", "rl")

if __name__ == "__main__":
    main()
