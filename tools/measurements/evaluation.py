"""Checks that `engram eval` prints the same bytes for any threads, batch size and ranks."""

import hashlib
import os
import shutil
import sys

from measurements import common

ARGUMENTS = (
    "RememberColor3-VLA-v0 TakeItBack-VLA-v0 ShellGameShuffleTouch-VLA-v0 BunchOfColors3-VLA-v0 "
    "SeqOfColors7-VLA-v0 BatteriesCheckerEasy-6-VLA-v0 --episodes 9 --obs rgb --policy oracle"
)


def add_options(parser):
    parser.add_argument(
        "--arguments", default=ARGUMENTS, help="of `engram eval`; default: %(default)s"
    )


def runs(engram, arguments):
    """Labels and commands."""
    words = [engram, "eval", *arguments.split(), "--json"]
    for threads in (1, 2):
        for num_envs in (1, 8, 64):
            more = ["--threads", threads, "--num-envs", num_envs]
            yield f"threads {threads}, num-envs {num_envs}", [*words, *more]
    if shutil.which("mpirun") is None:
        print("no mpirun here: ranks not checked")
        return
    os.environ |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    for ranks in (1, 2, 3):
        yield f"ranks {ranks}", ["mpirun", "--oversubscribe", "-n", ranks, *words]


def evaluate(options):
    """The first output, and the labels of those that differ from it."""
    first, different = None, []
    for label, words in runs(options.engram, options.arguments):
        output = common.run(words)
        first = first or output
        print(f"{'same     ' if output == first else 'DIFFERENT'}  {label}", flush=True)
        if output != first:
            different.append(label)
    return first, different


def run(options):
    first, different = evaluate(options)
    print(hashlib.sha256(first.encode()).hexdigest())
    sys.exit(1 if different else 0)
