"""Does stepping allocate? Resident memory and Python's own allocations over many steps.

python memory_growth.py [--steps 100000] [--num-envs 2]
"""

from __future__ import annotations

import argparse
import gc
import tracemalloc

import numpy as np

import engram


def resident() -> int:
    """Resident memory in bytes."""
    with open("/proc/self/statm") as statm:
        return int(statm.read().split()[1]) * 4096


def main() -> None:
    """Steps and prints what grew after the first tenth."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--id", default="RememberColor3-VLA-v0")
    parser.add_argument("--steps", type=int, default=100_000)
    parser.add_argument("--num-envs", type=int, default=2)
    parser.add_argument("--autoreset", default="SAME_STEP")
    args = parser.parse_args()

    env = engram.make_vec(args.id, args.num_envs, threads=1, autoreset_mode=args.autoreset)
    env.reset(seed=0)
    actions = np.zeros((args.num_envs, 7), np.float32)
    tracemalloc.start()
    for step in range(args.steps):
        if step == args.steps // 10:
            gc.collect()
            before = resident(), tracemalloc.get_traced_memory()[0]
        env.step(actions)
    gc.collect()
    after = resident(), tracemalloc.get_traced_memory()[0]
    counted = args.steps - args.steps // 10
    print(f"{counted} steps of {env}, {args.autoreset}")
    print(f"resident {before[0] / 1e6:.2f} -> {after[0] / 1e6:.2f} MB")
    print(f"traced   {before[1]} -> {after[1]} bytes, peak {tracemalloc.get_traced_memory()[1]}")


if __name__ == "__main__":
    main()
