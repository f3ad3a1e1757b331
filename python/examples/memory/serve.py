#!/usr/bin/env python3
"""Serves a trained policy to `engram eval` and `engram record`, as a process with pipes.

    agent="python3 python/examples/memory/serve.py runs/color3/agent.pt"
    engram eval RememberColor3-VLA-v0 --obs objects --policy-command "$agent" \
        --threads 1 --num-envs 50
    engram record RememberColor3-VLA-v0 --obs objects --policy-command "$agent" --out video.mp4

`--obs rgb` is for a policy that was trained on images. `serve.py AGENT --wiped` resets the memory
whenever an object appears (in students of clone.py until the hand moves): what is left is guessing.

A student of another variant of its task (distil.py --option) is played there:

    engram record TimedTransferEasy-VLA-v0 --obs objects --policy-command "$agent" --out video.mp4 \
        $(python3 python/examples/memory/serve.py runs/timed/agent.pt --switches)

One thread requests all episodes at once; more threads start a process each. The size of a request
changes the rounding of sums, and so the last digits of returns.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import pipe_policy
from env_options import switches
from inference import load_runner


def serve(runner):
    def act(task, request):
        try:
            actions = runner({**request, "worker": 0, "env_id": task})
        except ValueError as error:
            pipe_policy.send(pipe_policy.FAILED, str(error).encode())
            sys.exit(1)
        return [((len(action),), action) for action in actions.tolist()]

    pipe_policy.act = act
    pipe_policy.main()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("agent", type=Path, help="agent.pt of a learner's --out")
    parser.add_argument("--wiped", action="store_true", help="the memory is reset")
    parser.add_argument(
        "--switches", action="store_true", help="of the engram command, for its environment; ends"
    )
    args = parser.parse_args()
    runner = load_runner(args.agent, args.wiped)
    if args.switches:
        print(switches(runner.options))
    else:
        serve(runner)
