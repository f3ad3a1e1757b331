"""Score of the player: successes of the last ten episodes, beside the rates of policies."""

from __future__ import annotations

import collections
from typing import Any

EPISODES = 10


class Scores:
    """Finished episodes by task. A seed counts once: later its answer is known."""

    def __init__(self) -> None:
        self._results: dict[str, collections.deque[tuple[bool, bool | None]]] = {}
        self._seeds: dict[str, set[int]] = {}

    def add(self, id: str, seed: int, success: bool, first: bool | None) -> bool:
        """Adds an episode; returns True if it counts."""
        seeds = self._seeds.setdefault(id, set())
        if seed in seeds:
            return False
        seeds.add(seed)
        results = self._results.setdefault(id, collections.deque(maxlen=EPISODES))
        results.append((success, first))
        return True

    def of(self, description: Any) -> dict[str, Any]:
        """The score, and the rates of chance, sweep and oracle."""
        results = list(self._results.get(description["id"], ()))
        ceilings = description.get("ceilings") or {}
        sweep = (ceilings.get("sweep") or {}).get("success_once")
        oracle = (ceilings.get("oracle") or {}).get("success_once")
        rate = sum(success for success, _ in results) / len(results) if results else None
        answers = [first for _, first in results if first is not None]
        memory = None
        if rate is not None and sweep is not None and oracle is not None and oracle - sweep > 0.05:
            memory = (rate - sweep) / (oracle - sweep)
        return {
            "episodes": len(results),
            "of": EPISODES,
            "successes": sum(success for success, _ in results),
            "results": [success for success, _ in results],
            "rate": rate,
            "first_right": sum(answers) if answers else None,
            "first_answers": len(answers),
            "chance": description["chance"],
            "answer_chance": description.get("answer_chance"),
            "sweep": sweep,
            "oracle": oracle,
            "memory": memory,
        }
