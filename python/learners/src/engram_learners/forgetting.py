r"""Draws the forgetting curves of several policies, which `engram probe` has measured.

    engram probe RememberColor3-VLA-v0 --obs objects --probes forgetting --out probes/gru \
        --policy-command "python -m engram_learners.serve runs/gru/agent.pt"
    python -m engram_learners.forgetting gru=probes/gru lru=probes/lru --out forgetting.png

The share of right first answers over the delay between cue and question, with its 95 % interval;
the dotted line is chance. Points of a name that is given several times are one curve: those of a
short task and of its longer form, say.
"""

import argparse
import json
from pathlib import Path


def named(text):
    """A name and its folder, of "gru=probes/gru"."""
    name, _, folder = text.partition("=")
    if not folder:
        raise argparse.ArgumentTypeError(f"{text!r} given; NAME=FOLDER needed")
    return name, Path(folder)


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("probes", nargs="+", type=named, metavar="NAME=FOLDER")
    parser.add_argument("--out", type=Path, required=True, help="image")
    return parser.parse_args()


def probed(folder):
    """What was measured of the first task."""
    return json.loads((folder / "probe.json").read_text())["tasks"][0]


def curve_of(tasks):
    """Delays, rates, lower and upper ends; of a delay in several tasks, those of the first."""
    answers = {}
    for task in tasks:
        for point in task["forgetting"]["points"]:
            answers.setdefault(point["delay"], point["first_answer"])
    delays = sorted(answers)
    rates = [answers[delay]["rate"] for delay in delays]
    low, high = zip(*(answers[delay]["interval"] for delay in delays))
    return delays, rates, low, high


def main():
    args = arguments()
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(6.5, 3.8))
    curves = {}
    for name, folder in args.probes:
        curves.setdefault(name, []).append(probed(folder))
    for name, tasks in curves.items():
        delays, rates, low, high = curve_of(tasks)
        line = axes.plot(delays, rates, marker="o", label=name)[0]
        axes.fill_between(delays, low, high, alpha=0.12, color=line.get_color())
    first = next(iter(curves.values()))[0]
    axes.axhline(first["forgetting"]["answer_chance"], color="k", linestyle=":", linewidth=1)
    axes.set(title=first["env_id"], xlabel="delay, steps", ylabel="first answer is right")
    axes.set_ylim(0, 1.03)
    axes.set_xscale("symlog", linthresh=1, linscale=0.3)
    axes.set_xlim(left=0)
    axes.legend()
    axes.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(args.out, dpi=120)


if __name__ == "__main__":
    main()
