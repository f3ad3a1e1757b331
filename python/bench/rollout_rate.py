"""Overhead of Python over C++: three loops of random actions, in alternation.

    python rollout_rate.py [--id ID] [--num-envs N] [--steps T] [--rounds R] [--obs state|rgb]

Per round, in turn: the C++ command (`engram rollout`, built by scripts/build.sh), the C API
called straight from Python's extension with nothing in between, and the Gymnasium environment.
Prints the medians in environment steps per second, and the medians of the rounds' ratios.
"""

from __future__ import annotations

import argparse
import json
import pathlib
import statistics
import subprocess
import time

import engram

ROOT = pathlib.Path(__file__).resolve().parents[2]


def command_rate(args: argparse.Namespace) -> float:
    """Rate that the C++ command reports."""
    command = [
        args.engram, "rollout", args.id, "--num-envs", str(args.num_envs), "--steps",
        str(args.steps), "--obs", args.obs, "--policy", "random", "--json",
    ]  # fmt: skip
    output = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return json.loads(output)["env_steps_per_second"]


def extension_rate(env: engram.VectorEnv, steps: int) -> float:
    """Rate of the C API: act and step, no results taken."""
    env.reset(seed=0)
    actions = env.act("random")
    batch = env._batch
    start = time.perf_counter()
    for _ in range(steps):
        batch.act(1, actions)
        batch.step(actions)
    return env.num_envs * steps / (time.perf_counter() - start)


def gymnasium_rate(env: engram.VectorEnv, steps: int) -> float:
    """Rate of the environment as users step it."""
    env.reset(seed=0)
    actions = env.act("random")
    start = time.perf_counter()
    for _ in range(steps):
        env.act("random", actions)
        env.step(actions)
    return env.num_envs * steps / (time.perf_counter() - start)


def main() -> None:
    """Runs the rounds and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--id", default="RememberColor9-VLA-v0")
    parser.add_argument("--num-envs", type=int, default=256)
    parser.add_argument("--steps", type=int, default=100)
    parser.add_argument("--rounds", type=int, default=11)
    parser.add_argument("--obs", choices=["state", "rgb"], default="state")
    parser.add_argument("--engram", default=str(ROOT / "build/release/engram"))
    args = parser.parse_args()

    env = engram.make_vec(args.id, args.num_envs, obs_mode=args.obs)
    measured: dict[str, list[float]] = {"C++ command": [], "C API": [], "Gymnasium": []}
    for _ in range(args.rounds):
        measured["C++ command"].append(command_rate(args))
        measured["C API"].append(extension_rate(env, args.steps))
        measured["Gymnasium"].append(gymnasium_rate(env, args.steps))
    env.close()

    for name, rates in measured.items():
        print(f"{name:12} {statistics.median(rates):10.0f} env steps/s")
    for baseline in ("C++ command", "C API"):
        pairs = zip(measured["Gymnasium"], measured[baseline])
        ratio = statistics.median(own / other for own, other in pairs)
        print(f"Gymnasium / {baseline}: {ratio:.3f}")


if __name__ == "__main__":
    main()
