"""Steps per second, and the share of a task's own methods."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from engram.factory import make_vec
from engram.kit.checks.subject import Subject

_BESIDE = "RememberColor9-VLA-v0"
_ENVS, _SECONDS = 256, 0.4


def check(subject: Subject) -> None:
    if not subject.is_own:
        return
    options: dict[str, Any] = {"obs_mode": "none", "autoreset_mode": "SAME_STEP", "threads": 1}
    with subject.batch(_ENVS, **options, after_end="refuse") as env:
        before = subject.tasks[-1].__dict__["seconds"]
        rate, seconds = _rate(env)
        share = (subject.tasks[-1].__dict__["seconds"] - before) / seconds
    beside: Any = make_vec(_BESIDE, _ENVS, **options)
    other, _ = _rate(beside)
    beside.close()
    subject.add(
        "speed", "note",
        f"{rate:,.0f} steps/s of zero actions with one thread ({_BESIDE}: {other:,.0f}), "
        f"{share:.0%} of the time in the task's own methods",
        steps_per_second=round(rate), beside=round(other), share=round(share, 3),
    )  # fmt: skip


def _rate(env: Any) -> tuple[float, float]:
    """Environment steps per second, and all seconds."""
    zero = np.zeros(env.action_space.shape, np.float32)
    begin, steps = time.perf_counter(), 0
    env.reset(seed=0)
    while time.perf_counter() - begin < _SECONDS:
        env.step(zero)
        steps += 1
    seconds = time.perf_counter() - begin
    return steps * _ENVS / seconds, seconds
