"""How a trained policy does by the benchmark's protocol, beside what the task gives to others.

    python evaluate.py runs/color3/agent.pt
    python evaluate.py runs/color3/agent.pt --json

50 episodes with the benchmark's seeds. Chance is the rate of guessing; the sweep tries one answer
after the other and remembers nothing of the cue; the oracle knows.
"""

import argparse
import json
from pathlib import Path

from player import Player

import engram

FIGURES = ("success_once", "first_answer_correct")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("agent", type=Path, help="agent.pt of a learner's --out")
    add("--id", help="another task than that which it has learnt")
    add("--episodes", type=int, default=50)
    add("--seed", type=int, default=4242424242, help="of the first episode")
    add("--json", action="store_true", help="one JSON document in place of the table")
    add("--out", type=Path, help="folder for engram's own results")
    return parser.parse_args()


def evaluate(player, task, episodes, seed, out=None):
    """The figures of a policy, and those to compare them with."""
    results = engram.evaluate(
        player,
        task,
        obs=player.obs,
        episodes=episodes,
        seed=seed,
        threads=1,
        num_envs=50,
        output=out,
    )
    one, known = results["tasks"][0], engram.describe(task)
    others = known["ceilings"] or {}  # measured for engram's own tasks, not for variants
    unknown = dict.fromkeys(FIGURES)
    return {
        "id": task,
        "obs": player.obs,
        "episodes": episodes,
        "seed": seed,
        "policy": dict(zip(FIGURES, (one["sr"], one["first_answer_correct"]))),
        "chance": dict(zip(FIGURES, (known["chance"], known["answer_chance"]))),
        "sweep": others.get("sweep", unknown),
        "oracle": others.get("oracle", unknown),
    }


def table(figures):
    lines = ["{id} from {obs}, {episodes} episodes from seed {seed}".format(**figures)]
    lines.append(" " * 8 + "".join(f"{figure:>22}" for figure in FIGURES))
    for who in ("policy", "chance", "sweep", "oracle"):
        rates = (figures[who][figure] for figure in FIGURES)
        cells = ("-" if rate is None else f"{rate:.2f}" for rate in rates)
        lines.append(f"{who:8}" + "".join(f"{cell:>22}" for cell in cells))
    return "\n".join(lines)


def main():
    args = arguments()
    player = Player.load(args.agent)
    figures = evaluate(player, args.id or player.task, args.episodes, args.seed, args.out)
    print(json.dumps(figures) if args.json else table(figures))


if __name__ == "__main__":
    main()
