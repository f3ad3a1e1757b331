r"""Draws the forgetting curves of several policies, which `engram probe` has measured.

    engram probe RememberColor3-VLA-v0 --obs objects --probes forgetting --out probes/gru \
        --policy-command "python serve.py runs/gru/agent.pt"
    python forgetting.py gru=probes/gru lru=probes/lru --out forgetting.png

The share of right first answers over the delay between cue and question, with its 95 % interval;
the dotted line is chance.
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
    parser.add_argument("--out", type=Path, required=True, help="picture")
    return parser.parse_args()


def curve_of(folder):
    """The first task's forgetting: delays, rates, lower and upper ends, chance."""
    task = json.loads((folder / "probe.json").read_text())["tasks"][0]
    points = [(point["delay"], point["first_answer"]) for point in task["forgetting"]["points"]]
    delays = [delay for delay, _ in points]
    rates = [answer["rate"] for _, answer in points]
    low, high = zip(*(answer["interval"] for _, answer in points))
    return task["env_id"], delays, rates, low, high, task["forgetting"]["answer_chance"]


def main():
    args = arguments()
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(6.5, 3.8))
    for name, folder in args.probes:
        task, delays, rates, low, high, chance = curve_of(folder)
        line = axes.plot(delays, rates, marker="o", label=name)[0]
        axes.fill_between(delays, low, high, alpha=0.12, color=line.get_color())
    axes.axhline(chance, color="k", linestyle=":", linewidth=1)
    axes.set(title=task, xlabel="delay, steps", ylabel="first answer is right", ylim=(0, 1.03))
    axes.set_xscale("symlog", linthresh=1)
    axes.legend()
    axes.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(args.out, dpi=120)


if __name__ == "__main__":
    main()
