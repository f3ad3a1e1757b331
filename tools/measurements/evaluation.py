"""Checks that `engram eval` gives the same bytes for any threads, batch size, ranks and shards."""

import functools
import hashlib
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time

from measurements import common

ARGUMENTS = (
    "RememberColor3-VLA-v0 TakeItBack-VLA-v0 ShellGameShuffleTouch-VLA-v0 BunchOfColors3-VLA-v0 "
    "SeqOfColors7-VLA-v0 BatteriesCheckerEasy-6-VLA-v0 --episodes 9 --obs rgb --policy oracle"
)


def add_options(parser):
    parser.add_argument(
        "--arguments", default=ARGUMENTS, help="of `engram eval`; default: %(default)s"
    )


def merged(engram, arguments, count=7, kills=3):
    """The output of `engram merge`: shards in random order, of which some are killed once."""
    chance = random.Random(1)
    with tempfile.TemporaryDirectory() as folder:
        for place, number in enumerate(chance.sample(range(1, count + 1), count)):
            shard = ["--shard", f"{number}/{count}", "--out", folder]
            words = [engram, "eval", *arguments.split(), *shard]
            if place < kills:
                with subprocess.Popen(words, stderr=subprocess.DEVNULL) as process:
                    time.sleep(chance.uniform(0.2, 2))
                    process.kill()
            common.run(words)
        return common.run([engram, "merge", folder, "--json"])


def runs(engram, arguments):
    """Labels, and functions that return an output."""
    words = [engram, "eval", *arguments.split(), "--json"]
    for threads in (1, 2):
        for num_envs in (1, 8, 64):
            more = ["--threads", threads, "--num-envs", num_envs]
            play = functools.partial(common.run, [*words, *more])
            yield f"threads {threads}, num-envs {num_envs}", play
    yield "7 shards, 3 of them killed", functools.partial(merged, engram, arguments)
    if shutil.which("mpirun") is None:
        print("no mpirun here: ranks not checked")
        return
    os.environ |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    for ranks in (1, 2, 4):
        line = ["mpirun", "--oversubscribe", "-n", ranks, *words]
        yield f"ranks {ranks}", functools.partial(common.run, line)


def evaluate(options):
    """The first output, and the labels of those that differ from it."""
    first, different = None, []
    for label, play in runs(options.engram, options.arguments):
        begun = time.monotonic()
        output = play()
        seconds = time.monotonic() - begun
        first = first or output
        same = "same     " if output == first else "DIFFERENT"
        print(f"{same}  {label}: {seconds:.1f} s", flush=True)
        if output != first:
            different.append(label)
    return first, different


def run(options):
    first, different = evaluate(options)
    print(hashlib.sha256(first.encode()).hexdigest())
    sys.exit(1 if different else 0)
