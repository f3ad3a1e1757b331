"""Phase of the task in every picture of an episode, for plots.

Descriptions have phases in words. Phases whose lengths are drawn at the beginning are separated by
these lengths; phases that the robot's actions end, by infos.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import engram

_NONE = -1  # after the last phase
_CUE = "cue_steps_per_env"
_EMPTY = "empty_steps_per_env"  # of shuffles, too


class PhaseTrack:
    """Phases of the first environment's episode; `track` has the number of one per picture."""

    def __init__(self, env: engram.VectorEnv[Any], info: Mapping[str, Any]) -> None:
        self.track: list[int | None] = []
        names = tuple(phase["name"] for phase in env.description["phases"])
        drawn = env.drawn()
        self._rule = _RULES.get(names)
        lengths = [int(drawn[name][0]) for name in (_CUE, _EMPTY) if name in drawn]
        if self._rule is None and len(lengths) == len(names) - 1:
            self._rule = lambda _info, _phase: _by_length(len(self.track), lengths)
        self._phase = 0
        self.add(info)

    def add(self, info: Mapping[str, Any]) -> None:
        """Appends the phase of the next picture."""
        if self._rule is not None:
            self._phase = self._rule(info, self._phase)
        self.track.append(self._phase if self._rule is not None and self._phase != _NONE else None)


def _by_length(elapsed: int, lengths: list[int]) -> int:
    phase = 0
    while phase < len(lengths) and elapsed >= sum(lengths[: phase + 1]):
        phase += 1
    return phase


# --- rules by infos ---


def _is(info: Mapping[str, Any], name: str) -> bool:
    return bool(info[name][0])


def _traced(info: Mapping[str, Any], _phase: int) -> int:
    return 2 if _is(info, "action_mask") else 1 if _is(info, "demo_mask") else 0


def _blinked(info: Mapping[str, Any], phase: int) -> int:
    return 1 if phase or _is(info, "phase_ready") else 0


def _tested(info: Mapping[str, Any], _phase: int) -> int:
    return int(info["action_stage"][0])


def _there_and_back(info: Mapping[str, Any], _phase: int) -> int:
    return 1 if _is(info, "goal_reached_status") else 0


def _gathered(info: Mapping[str, Any], _phase: int) -> int:
    return 1 if _is(info, "flash_active") else 2 if _is(info, "all_on_disc") else 0


def _timed(info: Mapping[str, Any], phase: int) -> int:
    if _is(info, "past_window"):
        return _NONE
    return 2 if _is(info, "in_window") else 1 if phase or _is(info, "signal_on") else 0


_Rule = Callable[[Mapping[str, Any], int], int]
_RULES: dict[tuple[str, ...], _Rule] = {
    ("pre-demo", "demo", "action"): _traced,
    ("cue", "action"): _blinked,
    ("insert", "return", "confirm"): _tested,
    ("there", "back"): _there_and_back,
    ("wait", "count", "window"): _timed,
    ("move", "flash", "press"): _gathered,
    ("manipulation",): lambda _info, _phase: 0,
}
