"""Cost of the original's interface, in alternation with engram's own, step by step.

    python mikasa_rates.py [--id ID] [--num-envs N] [--steps T] [--obs state|rgb|all] [--threads T]
                           [--profile]

Two batches of the same episodes get the same actions in turns, in one process: one by
`engram.make_vec`, one by `gym.make` after `import engram.mikasa`, with images within
`apply_mikasa_vla_wrappers`. Prints milliseconds per step of both and their ratios: of the medians,
of the minima, and the median of the pairs'. On a busy machine the minima say most. --profile: where
the time of the original's interface goes.
"""

from __future__ import annotations

import argparse
import cProfile
import gc
import pstats
import statistics
import time
from typing import Any

import gymnasium as gym
import numpy as np
import torch

import engram
import engram.mikasa as mikasa


def own_interface(args: argparse.Namespace, mode: Any) -> engram.VectorEnv:
    """Engram's own interface, with the same episodes as the original's."""
    return engram.make_vec(
        args.id,
        args.num_envs,
        obs_mode=mode,
        threads=args.threads,
        rules="original",
        freeze_cue=mode == "rgb",
        autoreset_mode="DISABLED",
        after_end="continue",
        terminate_on_success=False,
        terminate_on_failure=False,
    )


def mikasa_interface(args: argparse.Namespace, mode: str) -> Any:
    """The original's interface, as scripts make it."""
    env = gym.make(
        args.id,
        num_envs=args.num_envs,
        obs_mode=mode,
        threads=args.threads,
        control_mode="pd_ee_delta_pose",
    )
    return mikasa.apply_mikasa_vla_wrappers(env) if mode == "rgb" else env


def measure(args: argparse.Namespace, mode: str) -> tuple[list[float], list[float]]:
    """Seconds of each step, of both interfaces."""
    interfaces = (own_interface(args, mode), mikasa_interface(args, mode))
    horizon = interfaces[0].description["horizon"]
    shape = interfaces[0].action_space.shape
    rng = np.random.default_rng(0)
    times: tuple[list[float], list[float]] = ([], [])
    results: list[Any] = [None, None]  # held until the next step, as loops do
    profile = cProfile.Profile() if args.profile else None
    gc.disable()
    for step in range(args.steps + 5):
        if step % horizon == 0:
            for interface in interfaces:
                interface.reset(seed=step)
        action = rng.uniform(-1, 1, shape).astype(np.float32)
        given = (action, torch.from_numpy(action))
        for which in (0, 1) if step % 2 else (1, 0):
            if profile and which:
                profile.enable()
            start = time.perf_counter()
            results[which] = interfaces[which].step(given[which])
            spent = time.perf_counter() - start
            if profile:
                profile.disable()
            if step >= 5:
                times[which].append(spent)
    gc.enable()
    for interface in interfaces:
        interface.close()
    if profile:
        pstats.Stats(profile).sort_stats("tottime").print_stats(25)
    return times


def main() -> None:
    """Measures and prints a line for each mode."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--id", default="RememberColor9-VLA-v0")
    parser.add_argument("--num-envs", type=int, default=256)
    parser.add_argument("--steps", type=int, default=500)
    parser.add_argument("--obs", choices=["state", "rgb", "all"], default="all")
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--profile", action="store_true")
    args = parser.parse_args()
    for mode in ("state", "rgb") if args.obs == "all" else (args.obs,):
        own, other = measure(args, mode)
        pairs = statistics.median(b / a for a, b in zip(own, other))
        print(
            f"{mode:5} own {1e3 * statistics.median(own):.2f} ms (least {1e3 * min(own):.2f}), "
            f"original's {1e3 * statistics.median(other):.2f} ms (least {1e3 * min(other):.2f}), "
            f"ratio of medians {statistics.median(other) / statistics.median(own):.3f}, "
            f"of minima {min(other) / min(own):.3f}, of pairs {pairs:.3f}"
        )


if __name__ == "__main__":
    main()
