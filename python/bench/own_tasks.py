"""Speed of a task in Python beside the same one in C++: RememberColor9.

    python own_tasks.py [--num-envs 256] [--threads 1] [--obs state] [--actions oracle]

Both step in turns in one process; the ratio is the median of all rounds' ratios. The goals are 0.6
with state observations and 0.9 with images, at 256 environments.
"""

from __future__ import annotations

import argparse
import statistics
import time
from pathlib import Path

import numpy as np

import engram

FILE = Path(__file__).parents[1] / "examples" / "own_tasks" / "remember_color.py"
IDS = ("RememberColor9-VLA-v0", "MyRememberColor9-v0")


def seconds(env: engram.VectorEnv, actions: list[np.ndarray]) -> float:
    begin = time.perf_counter()
    for action in actions:
        env.step(action)
    return time.perf_counter() - begin


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--num-envs", type=int, default=256)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--obs", default="state")
    parser.add_argument("--actions", choices=("oracle", "zero", "random"), default="oracle")
    parser.add_argument("--rounds", type=int, default=15)
    args = parser.parse_args()
    engram.load_tasks(FILE)
    steps = 26 if args.obs == "rgb" else 104  # whole episodes
    envs = [
        engram.make_vec(
            id, num_envs=args.num_envs, threads=args.threads, obs_mode=args.obs, copy=False
        )
        for id in IDS
    ]
    rates: list[list[float]] = [[], []]
    for _ in range(args.rounds):
        for env, rate in zip(envs, rates):
            env.reset(seed=1)
            actions = []
            for _ in range(steps):  # those of this task's episodes, recorded beforehand
                actions.append(env.act(args.actions).copy())
                env.step(actions[-1])
            env.reset(seed=1)
            rate.append(args.num_envs * steps / seconds(env, actions))
    ratios = [own / built_in for built_in, own in zip(*rates)]
    for id, rate in zip(IDS, rates):
        print(f"{id:24} {statistics.median(rate):10,.0f} steps/s")
    print(f"ratio {statistics.median(ratios):.3f} ({min(ratios):.3f} to {max(ratios):.3f})")


if __name__ == "__main__":
    main()
