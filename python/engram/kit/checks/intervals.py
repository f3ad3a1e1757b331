"""Confidence intervals of success rates."""

from __future__ import annotations

import math

import numpy as np

_TAIL = 0.0005  # on either side: 99.9 %


def interval(successes: int, episodes: int) -> tuple[float, float]:
    """The exact two-sided 99.9 % interval of a rate (Clopper and Pearson)."""
    low = 0.0 if successes == 0 else _root(successes, episodes)
    high = 1.0 if successes == episodes else 1 - _root(episodes - successes, episodes)
    return low, high


def _root(successes: int, episodes: int) -> float:
    """The rate with which `successes` or more are just too improbable."""
    low, high = 0.0, 1.0
    for _ in range(40):
        middle = (low + high) / 2
        if _at_least(successes, episodes, middle) < _TAIL:
            low = middle
        else:
            high = middle
    return low


def _at_least(successes: int, episodes: int, rate: float) -> float:
    if rate in (0.0, 1.0):
        return rate
    k = np.arange(successes, episodes + 1)
    ways = [math.lgamma(episodes + 1) - math.lgamma(i + 1) - math.lgamma(episodes - i + 1)
            for i in k]  # fmt: skip
    logs = np.array(ways) + k * math.log(rate) + (episodes - k) * math.log1p(-rate)
    return float(np.exp(logs).sum())
