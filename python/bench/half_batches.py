"""Gain of stepping in two halves when the policy runs on another device.

    python half_batches.py [--num-envs 256] [--latency 0.03] [--rounds 15]

Alternates one batch, whose simulation waits for the policy and the other way round, with two
half-batches of which one is simulated while the policy works on the other. The policy is a
stand-in for a network on an accelerator: it costs no core, but takes `latency` seconds per batch
of `num_envs`, and half of that for half of them.
"""

from __future__ import annotations

import argparse
import statistics
import time
from typing import Any

import numpy as np

import engram


def make_policy(latency: float, num_envs: int) -> Any:
    """A function from observations to actions with a given latency."""

    def policy(obs: np.ndarray) -> np.ndarray:
        time.sleep(latency * len(obs) / num_envs)
        return np.zeros((len(obs), 7), np.float32)

    return policy


def one_batch(env: engram.VectorEnv, policy: Any, steps: int) -> None:
    """Network, simulation, network, simulation, ... ."""
    obs, _ = env.reset(seed=0)
    for _ in range(steps):
        obs, *_ = env.step(policy(obs))


def two_halves(halves: list[engram.VectorEnv], policy: Any, steps: int) -> None:
    """The network works on one half while the other is simulated."""
    size = halves[0].num_envs
    obs = [half.reset(seed=size * i)[0] for i, half in enumerate(halves)]
    halves[0].step_async(policy(obs[0]))
    for _ in range(steps):
        for now, other in ((0, 1), (1, 0)):
            halves[other].step_async(policy(obs[other]))
            obs[now], *_ = halves[now].step_wait()
    halves[0].step_wait()


def main() -> None:
    """Runs the rounds and prints the medians."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--id", default="RememberColor9-VLA-v0")
    parser.add_argument("--num-envs", type=int, default=256)
    parser.add_argument("--latency", type=float, default=0.03)
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--steps", type=int, default=25)
    args = parser.parse_args()

    whole = engram.make_vec(args.id, args.num_envs)
    halves = [engram.make_vec(args.id, args.num_envs // 2) for _ in range(2)]
    policy = make_policy(args.latency, args.num_envs)
    rates: dict[str, list[float]] = {"one batch": [], "two halves": []}
    for _ in range(args.rounds):
        for name, run in (
            ("one batch", lambda: one_batch(whole, policy, args.steps)),
            ("two halves", lambda: two_halves(halves, policy, args.steps)),
        ):
            start = time.perf_counter()
            run()
            rates[name].append(args.num_envs * args.steps / (time.perf_counter() - start))
    for name, values in rates.items():
        print(f"{name:10} {statistics.median(values):8.0f} env steps/s")
    pairs = zip(rates["two halves"], rates["one batch"])
    print(f"two halves / one batch: {statistics.median(a / b for a, b in pairs):.2f}")


if __name__ == "__main__":
    main()
