r"""Options of the environment that a student is trained with, and then played with.

    python -m engram_learners.distil --id TimedTransferEasy-VLA-v0 --option observe_time
    python -m engram_learners.distil \
        --option 'constants={"CUE_PHASE_STEPS": [30, 50], "max_episode_steps": 90}'

The names are keywords of `engram.make_vec`. agent.pt has them: evaluate.py plays its variant, and
serve.py --switches prints what the engram command needs for it.
"""

import argparse
import json
import shlex

import numpy as np
import torch

import engram

TIME = "observe_time"
NAMES = (TIME, "control_mode", "rules", "task_options", "constants")


def option(text):
    """A name and its value, of "rules=original"; true if there is none. Values may be JSON."""
    name, equals, value = text.partition("=")
    if name not in NAMES:
        raise argparse.ArgumentTypeError(f"{name!r} given; {', '.join(NAMES)} allowed")
    try:
        return name, json.loads(value) if equals else True
    except ValueError:
        return name, value


def add_to(parser):
    """Adds --option, whose value is a list of pairs, to a learner's arguments."""
    parser.add_argument(
        "--option",
        nargs="+",
        default=[],
        type=option,
        metavar="NAME[=VALUE]",
        help=f"of the environment, also where it is played: {', '.join(NAMES)}",
    )


def of_evaluation(options):
    """Those that `engram.evaluate` takes; every policy gets the time there."""
    return {name: value for name, value in options.items() if name != TIME}


def switches(options):
    """Words of the engram command that make the same environment."""
    words = []
    for name, value in of_evaluation(options).items():
        if name in ("constants", "task_options"):
            switch = "--set" if name == "constants" else "--option"
            words += [w for key, one in value.items() for w in (switch, f"{key}={plain(one)}")]
        else:
            words += [f"--{name.replace('_', '-')}", value]
    return shlex.join(words)


def plain(value):
    return value if isinstance(value, str) else json.dumps(value)


class Time:
    """The column `time` of rows of objects, from the steps that every policy knows."""

    def __init__(self, options):
        self.options, self.columns = options, {}

    def add(self, task, rows, steps):
        """Rows (N, D) without it, control steps so far (N,) -> rows (N, D + 1), to the bit."""
        if task not in self.columns:
            known = engram.describe(task, obs_mode="objects", **self.options)
            offset = next(f["offset"] for f in known["state_fields"] if f["name"] == "time")
            self.columns[task] = offset, np.float32(1) / np.float32(known["horizon"])
        offset, share = self.columns[task]
        time = torch.from_numpy(np.minimum(1, np.array(steps, dtype=np.float32) * share))
        return torch.cat([rows[:, :offset], time[:, None], rows[:, offset:]], -1)
