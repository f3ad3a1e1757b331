"""Phases of an episode that follow one another."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from engram.errors import InvalidArgumentError
from engram.kit.scene import Mask

if TYPE_CHECKING:
    from engram.kit.declarations import Declared


class _Start:
    """The step in which a phase begins: a sum of draws and a number."""

    def __init__(self, draws: tuple[str, ...] = (), steps: int = 0) -> None:
        self.draws = draws
        self.steps = steps

    def after(self, length: str | int) -> _Start:
        if isinstance(length, str):
            return _Start((*self.draws, length), self.steps)
        return _Start(self.draws, self.steps + length)

    def __str__(self) -> str:
        return " + ".join([*self.draws, *([str(self.steps)] if self.steps else [])])


class Phases:
    """Base of ``Task`` with what tells phases apart."""

    n: int
    elapsed: NDArray[np.int32]
    cue_end: NDArray[np.int32]
    freeze_steps: NDArray[np.int32]
    horizon: int
    time_to_act: int
    frozen_cue: bool

    _declared: Declared
    _starts: dict[str, tuple[_Start, str | None]]  # of a phase, and the name of the next one

    def start_of(self, phase: str) -> NDArray[np.int32]:
        """The value of elapsed in which a phase begins: (n,)."""
        start = self._start(phase)[0]
        total: Any = None
        for name in start.draws:
            steps = getattr(self, name)
            total = steps if total is None else total + steps
        if total is None:
            return np.full(self.n, start.steps, np.int32)
        return total + np.int32(start.steps) if start.steps else total

    def begins(self, phase: str) -> Mask:
        """Whether a phase begins in this step: (n,)."""
        return self.elapsed == self.start_of(phase)

    def in_phase(self, phase: str) -> Mask:
        """Whether it is a phase: (n,)."""
        following = self._start(phase)[1]
        if following is None:
            return self.elapsed >= self.start_of(phase)
        if self._starts[phase][0].draws or self._starts[phase][0].steps:
            return (self.elapsed >= self.start_of(phase)) & (
                self.elapsed < self.start_of(following)
            )
        return self.elapsed < self.start_of(following)

    def _start(self, phase: str) -> tuple[_Start, str | None]:
        try:
            return self._starts[phase]
        except KeyError:
            allowed = ", ".join(self._starts) or "none, add_phases declares them"
            raise InvalidArgumentError(f"phase: {phase!r} given; allowed: {allowed}") from None

    # --- for the engine ---

    def _find_starts(self) -> None:
        """The beginnings of the declared phases."""
        phases = self._declared.phases
        start, starts = _Start(), {}
        for i, (name, length) in enumerate(phases):
            if name in starts:
                raise InvalidArgumentError(f"phases: {name!r} given twice")
            starts[name] = (start, phases[i + 1][0] if length is not None else None)
            if length is not None:
                start = start.after(length)
        self.__dict__["_starts"] = starts
        self._check_budget(start)

    def _check_budget(self, last: _Start) -> None:
        """Refuses constants that leave no time to act in the last phase."""
        greatest = {one["name"]: one.get("high", 0) for one in self._declared.draws}
        total = last.steps + sum(greatest[name] for name in last.draws) + self.time_to_act
        if self._declared.phases and total > self.horizon:
            words = "".join(f"{name} {greatest[name]} + " for name in last.draws)
            words += f"{last.steps} + " if last.steps else ""
            raise InvalidArgumentError(
                f"constants leave no time to act: {words}{self.time_to_act} to act = {total} "
                f"control steps, more than max_episode_steps {self.horizon}"
            )

    def _conditions(self) -> list[list[str]]:
        """Names and conditions of the declared phases."""
        found = []
        for name, (start, following) in self._starts.items():
            end = "" if following is None else str(self._starts[following][0])
            begin = str(start)
            if not end:
                condition = f"elapsed >= {begin}"
            else:
                condition = f"{begin} <= elapsed < {end}" if begin else f"elapsed < {end}"
            found.append([name, condition])
        return found

    def _reset_phases(self) -> None:
        """The end of the cue and of the freeze of an episode that begins."""
        following = self._starts.get("cue", (None, None))[1]
        if following is not None:
            self.cue_end[:] = self.start_of(following)
        if self.frozen_cue and self._starts:
            self.freeze_steps[:] = self.start_of(next(reversed(self._starts)))
