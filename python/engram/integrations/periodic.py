"""Evaluations during a training: the same episodes each time, within a budget."""

from __future__ import annotations

import json
import math
import os
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from engram._args.values import integer, path
from engram.errors import InvalidArgumentError
from engram.evaluation import evaluate

# Apart from the benchmark's, so that no checkpoint is chosen by the episodes of its results.
SEED = 2_000_000_000
_Z = 1.959963984540054  # of 95 %


class PeriodicEvaluation:
    """Evaluates a policy after each number of steps of its training.

    ::

        evaluation = PeriodicEvaluation("RememberColor3-VLA-v0", every=20_000, obs="objects")
        for step in range(1_000_000):
            ...  # the training
            evaluation(step, policy)

    Episodes are played in groups of ``num_envs`` that begin together. After each group it stops
    if the episodes or the seconds are used up, or if the interval is narrow enough. Nothing is kept
    between two evaluations but their records.

    Args:
        id: Task.
        every: Steps of the training between two evaluations; the first one is due at step 0.
        episodes: The most episodes of an evaluation.
        seconds: The most time of one; the group in which it is used up is finished. None: any.
        width: Of the 95 % interval of the success rate that is narrow enough. None: any.
        num_envs: Episodes of a group.
        seed: Of the first episode; the i-th one has seed + i in every evaluation.
        file: JSON lines; each record is added. None: none.
        **options: Others of ``engram.evaluate``, such as ``obs``.

    Attributes:
        records: One for each evaluation: ``step``, ``episodes``, ``success`` (a rate) with ``low``
            and ``high`` (Wilson's 95 % interval), ``first_answer`` (the share of right first
            answers; None in tasks without), ``chance`` (the success of guessing), ``seconds``,
            ``stopped`` ("episodes", "seconds" or "width"), and against the evaluation before, over
            the ``pairs`` of episodes that both have: how many were ``gained`` and ``lost``, and
            ``p_value`` (McNemar's exact test).
    """

    def __init__(
        self,
        id: str,
        *,
        every: int,
        episodes: int = 200,
        seconds: float | None = None,
        width: float | None = None,
        num_envs: int = 25,
        seed: int = SEED,
        file: str | os.PathLike[str] | None = None,
        **options: Any,
    ) -> None:
        for name, value, most in (("seconds", seconds, math.inf), ("width", width, 1.0)):
            if value is not None and not 0 < value <= most:
                bound = f" and at most {most:g}" if most < math.inf else ""
                raise InvalidArgumentError(f"{name}: {value!r} given, more than 0{bound} needed")
        self.id = id
        self.every = integer("every", every, 1, 2**62)
        self.episodes = integer("episodes", episodes, 1, 2**31 - 1)
        self.seconds = seconds
        self.width = width
        self.num_envs = integer("num_envs", num_envs, 1, 2**31 - 1)
        self.seed = integer("seed", seed, 0, 2**62)
        self.file = None if file is None else Path(path("file", file))
        self._options = {"threads": 1, **options}
        self._next = 0
        self._before: list[bool] = []
        self.records: list[dict[str, Any]] = []

    def due(self, step: int) -> bool:
        """Whether an evaluation is due at that step."""
        return step >= self._next

    def __call__(self, step: int, policy: Any) -> dict[str, Any] | None:
        """Evaluates if it is due; returns the record, or None.

        policy: As of ``engram.evaluate``.
        """
        return self.run(step, policy) if self.due(step) else None

    def run(self, step: int, policy: Any) -> dict[str, Any]:
        """Evaluates now; returns the record."""
        self._next = step + self.every
        begin = time.monotonic()
        successes: list[bool] = []
        answers: list[bool | None] = []
        chance: float | None = None
        stopped = ""
        while not stopped:
            task = self._group(policy, len(successes))
            successes += task["successes"]
            answers += task["first_answers_correct"] or []
            chance = task["chance"]
            stopped = self._reason(successes, time.monotonic() - begin)
        record = {
            "step": step,
            **_rate(successes),
            "first_answer": sum(map(bool, answers)) / len(answers) if answers else None,
            "chance": chance,
            "seconds": time.monotonic() - begin,
            "stopped": stopped,
            **_change(self._before, successes),
        }
        self._before = successes
        self.records.append(record)
        if self.file is not None:
            with open(self.file, "a", encoding="utf-8") as file:
                file.write(json.dumps(record) + "\n")
        return record

    def _group(self, policy: Any, done: int) -> dict[str, Any]:
        count = min(self.num_envs, self.episodes - done)
        result = evaluate(
            policy,
            self.id,
            episodes=count,
            num_envs=count,
            seed=self.seed + done,
            **self._options,
        )
        return result["tasks"][0]

    def _reason(self, successes: Sequence[bool], seconds: float) -> str:
        """Why it stops; "" if it goes on."""
        if len(successes) >= self.episodes:
            return "episodes"
        if self.seconds is not None and seconds >= self.seconds:
            return "seconds"
        rate = _rate(successes)
        if self.width is not None and rate["high"] - rate["low"] <= self.width:
            return "width"
        return ""


def _rate(successes: Sequence[bool]) -> dict[str, Any]:
    """The rate with Wilson's interval."""
    n, rate = len(successes), sum(successes) / len(successes)
    middle = rate + _Z**2 / (2 * n)
    half = _Z * math.sqrt(rate * (1 - rate) / n + _Z**2 / (4 * n**2))
    scale = 1 + _Z**2 / n
    low, high = max(0.0, (middle - half) / scale), min(1.0, (middle + half) / scale)
    return {"episodes": n, "success": rate, "low": low, "high": high}


def _change(before: Sequence[bool], now: Sequence[bool]) -> dict[str, Any]:
    """Episodes that both have."""
    pairs = list(zip(before, now))
    gained = sum(b and not a for a, b in pairs)
    lost = sum(a and not b for a, b in pairs)
    n = gained + lost
    tail = sum(math.comb(n, i) for i in range(min(gained, lost) + 1)) / 2**n
    return {"pairs": len(pairs), "gained": gained, "lost": lost, "p_value": min(1.0, 2 * tail)}


class Lockstep:
    """A policy that acts for a whole batch in every step, as one of ``engram.evaluate``.

    Args:
        act: Takes observations of all episodes of a group, as ``engram.evaluate`` has them, and a
            mask of those that begin; returns actions (N, A). Observations of ended episodes are
            those of their last question.
    """

    def __init__(self, act: Callable[[dict[str, Any], Any], Any]) -> None:
        self._act = act
        self._seen: dict[str, Any] = {}

    def __call__(self, observation: dict[str, Any]) -> Any:
        """Actions of the episodes that need one."""
        slots, first = observation["slot"], observation["first"].astype(bool)
        if first.all() and sorted(slots) == list(range(len(slots))):
            self._seen = _in_order(observation, slots)
        elif first.any():
            raise InvalidArgumentError(
                "evaluation: episodes that do not begin together given; as many num_envs as "
                "episodes, and threads=1, needed"
            )
        else:
            _update(self._seen, observation, slots)
        begins = np.full(len(self._seen["slot"]), first.all())
        return np.asarray(self._act(self._seen, begins), np.float32)[slots]


def _in_order(observation: dict[str, Any], slots: Any) -> dict[str, Any]:
    """The arrays and instructions of a group, by slot."""
    order = slots.argsort()
    result: dict[str, Any] = {"instruction": [observation["instruction"][i] for i in order]}
    for name in ("rgb", "state", "proprio", "slot", "step"):
        if observation[name] is not None:
            result[name] = observation[name][order].copy()
    return result


def _update(seen: dict[str, Any], observation: dict[str, Any], slots: Any) -> None:
    """Changes the rows of some of a group."""
    for row, slot in enumerate(slots):
        seen["instruction"][slot] = observation["instruction"][row]
    for name in seen.keys() - {"instruction"}:
        seen[name][slots] = observation[name]
