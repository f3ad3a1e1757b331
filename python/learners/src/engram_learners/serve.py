r"""Serves a trained policy to `engram eval` and `engram record`, as a process with pipes.

    agent="python3 -m engram_learners.serve runs/color3/agent.pt"
    engram eval RememberColor3-VLA-v0 --obs objects --policy-command "$agent" \
        --threads 1 --num-envs 50
    engram record RememberColor3-VLA-v0 --obs objects --policy-command "$agent" --out video.mp4

`--obs rgb` is for a policy that was trained on images. `serve.py AGENT --wiped` resets the memory
whenever an object appears (in students of clone.py until the hand moves): what is left is guessing.

A student of another variant of its task (distil.py --option) is played there:

    engram record TimedTransferEasy-VLA-v0 --obs objects --policy-command "$agent" --out video.mp4 \
        $(python3 -m engram_learners.serve runs/timed/agent.pt --switches)

One thread requests all episodes at once; more threads start a process each. The size of a request
changes the rounding of sums, and so the last digits of returns.
"""

import argparse
from pathlib import Path

from engram.errors import InvalidArgumentError
from engram.servers.bridge import serve_pipes
from engram.servers.identity import identity_of_file
from engram_learners.env_options import switches
from engram_learners.inference import load_runner


def act(runner, observation):
    """The runner's actions (N, A) as chunks (1, A) of an action each."""
    try:
        return list(runner(observation)[:, None])
    except ValueError as error:
        raise InvalidArgumentError(str(error)) from error


def main():
    parser = argparse.ArgumentParser(
        prog="python -m engram_learners.serve", description=__doc__.splitlines()[0]
    )
    parser.add_argument("agent", type=Path, help="agent.pt of a learner's --out")
    parser.add_argument("--wiped", action="store_true", help="the memory is reset")
    parser.add_argument(
        "--switches", action="store_true", help="of the engram command, for its environment; ends"
    )
    args = parser.parse_args()
    runner = load_runner(args.agent, args.wiped)
    if args.switches:
        print(switches(runner.options))
        return 0
    identity = {**identity_of_file(args.agent), "wiped": args.wiped}
    return serve_pipes(lambda _: lambda observation: act(runner, observation), identity)


if __name__ == "__main__":
    raise SystemExit(main())
