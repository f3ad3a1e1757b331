"""Score of the player: successes of the last ten episodes, beside the rates of policies."""

from __future__ import annotations

import collections
from typing import Any

EPISODES = 10
_GAP = 0.05  # between sweep and oracle; where it is less, success does not show memory


def rate_of(description: Any, policy: str) -> float | None:
    """The measured success rate of one of engram's own policies; None if there is none."""
    ceilings = description.get("ceilings") or {}
    rate: float | None = (ceilings.get(policy) or {}).get("success_once")
    return rate


class Scores:
    """Finished episodes by task, with and without choices.

    A seed counts once: later its answer is known.
    """

    def __init__(self) -> None:
        self._results: dict[tuple[str, bool], collections.deque[tuple[bool, bool | None]]] = {}
        self._seeds: dict[str, set[int]] = {}

    def add(
        self, id: str, seed: int, success: bool, first: bool | None, choices: bool = False
    ) -> bool:
        """Adds an episode; returns True if it counts."""
        seeds = self._seeds.setdefault(id, set())
        if seed in seeds:
            return False
        seeds.add(seed)
        results = self._results.setdefault((id, choices), collections.deque(maxlen=EPISODES))
        results.append((success, first))
        return True

    def of(self, description: Any, choices: bool = False) -> dict[str, Any]:
        """The score, and the rates of chance, sweep and oracle.

        Sweep is a policy that acts: it is no measure of answers by name.
        """
        results = list(self._results.get((description["id"], choices), ()))
        sweep, oracle = rate_of(description, "sweep"), rate_of(description, "oracle")
        chance = description["chance"]
        if choices:
            sweep, chance = None, description["choices"]["chance"]
        rate = sum(success for success, _ in results) / len(results) if results else None
        answers = [first for _, first in results if first is not None]
        return {
            "episodes": len(results),
            "of": EPISODES,
            "successes": sum(success for success, _ in results),
            "results": [success for success, _ in results],
            "rate": rate,
            "first_right": sum(answers) if answers else None,
            "first_answers": len(answers),
            "chance": chance,
            "answer_chance": description.get("answer_chance"),
            "sweep": sweep,
            "oracle": oracle,
            "memory": _memory(rate, sweep, oracle) if len(results) == EPISODES else None,
        }


def _memory(rate: float | None, sweep: float | None, oracle: float | None) -> float | None:
    """Between 0, as good as without memory, and 1, as the oracle; ten episodes tell no more."""
    if rate is None or sweep is None or oracle is None or oracle - sweep <= _GAP:
        return None
    return min(1.0, max(0.0, (rate - sweep) / (oracle - sweep)))
