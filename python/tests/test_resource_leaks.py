"""Batches that are opened and closed leave nothing behind."""

from __future__ import annotations

import gc
import os
from pathlib import Path

import engram

IDS = [
    "RotateLenientPos-VLA-v0",
    "InterceptSlow-VLA-v0",
    "TakeItBack-VLA-v0",
    "RememberColor3-VLA-v0",
]


def resources() -> dict[str, int]:
    gc.collect()
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return {
        "threads": len(os.listdir("/proc/self/task")),
        "descriptors": len(os.listdir("/proc/self/fd")),
        "memory": pages * os.sysconf("SC_PAGE_SIZE"),
    }


def cycle(number: int) -> None:
    """A batch's whole life: rows or images, closed or merely dropped."""
    env = engram.make_vec(
        IDS[number % len(IDS)],
        num_envs=1 + number % 3,
        threads=1 + number % 2,
        obs_mode="rgb" if number % 20 == 0 else "state",
        image_size=16,
    )
    env.reset(seed=number)
    env.step(env.act("oracle"))
    if number % 7 > 0:
        env.close()


def test_a_thousand_batches_leave_nothing_behind():
    for number in range(100):
        cycle(number)
    before = resources()
    for number in range(1000):
        cycle(number)
    after = resources()
    # Threads of tests that ran before may end meanwhile.
    assert after["threads"] <= before["threads"]
    assert after["descriptors"] <= before["descriptors"]
    # The allocator's own noise is a few MiB; a batch that stayed takes hundreds of KiB.
    assert after["memory"] - before["memory"] < 8 * 2**20
