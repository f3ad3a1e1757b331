"""Scripted policies: servos, tours and guesses, for ``oracle``, ``blind`` and ``sweep``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engram import _core
from engram.errors import InvalidArgumentError
from engram.kit.scene import Mask, checked_mask

GRIPPER_OPEN = 1.0
GRIPPER_CLOSED = -0.6  # closed, without squeezing
TOOL_DOWN = (0.0, 1.0, 0.0, 0.0)  # (w, x, y, z)

Reals = NDArray[np.float64]


class Motion:
    """Base of ``Task`` with what scripts do."""

    n: int
    elapsed: NDArray[np.int32]
    episode: NDArray[np.uint64]
    policy_key: NDArray[np.uint64]
    choice: NDArray[np.int32]
    choices: Sequence[str]
    choice_count: int
    tcp_pos: Reals
    tcp_quat: Reals
    qvel: Reals
    actions: NDArray[np.float32]

    def servo(
        self,
        goal: ArrayLike,
        *,
        orientation: ArrayLike = TOOL_DOWN,
        gripper: ArrayLike = GRIPPER_CLOSED,
        where: Mask | None = None,
    ) -> None:
        """Writes actions that bring the TCP to a goal, as fast as the drives allow.

        Args:
            goal: m, (3,) or (n, 3).
            orientation: (w, x, y, z), (4,) or (n, 4); pointing down if not given.
            gripper: GRIPPER_OPEN, GRIPPER_CLOSED, -1 to squeeze, or (n,).
            where: Environments that do it (n,); None: all.
        """
        out = np.empty((self.n, 7), np.float32)
        _core.servo_tcp(
            _readable(self.tcp_pos),
            _readable(self.tcp_quat),
            self._rows("goal", goal, 3),
            self._rows("orientation", orientation, 4),
            self._each("gripper", gripper),
            out,
        )
        self._write(out, where)

    def rest(self, *, gripper: ArrayLike = GRIPPER_CLOSED, where: Mask | None = None) -> None:
        """Writes actions that leave the arm where it is."""
        out = np.zeros((self.n, 7), np.float32)
        out[:, 6] = gripper
        self._write(out, where)

    def touch(
        self,
        points: ArrayLike,
        *,
        clearance: float = 0.06,
        gripper: ArrayLike = GRIPPER_CLOSED,
        where: Mask | None = None,
    ) -> None:
        """Writes actions that come down on points from above and stay there.

        The tool leans outwards where the points are far from the robot's base.

        Args:
            points: m, (3,) or (n, 3).
            clearance: Height above the point during the approach, m.
            gripper: See ``servo``.
            where: Environments that do it (n,); None: all.
        """
        goal = self.from_above(points, clearance)
        self.servo(goal, orientation=self.lean(points), gripper=gripper, where=where)

    def tour(
        self,
        stops: ArrayLike,
        *,
        reach: float = 0.025,
        again: bool = False,
        rests: bool = True,
        start_height: float = 0.13,
        gripper: ArrayLike = GRIPPER_CLOSED,
        where: Mask | None = None,
    ) -> None:
        """Writes actions that visit one stop after another, without memory, for ``sweep``.

        Stops are visited in the order of their angle about the robot's base; where the TCP is now
        tells which one is next.

        Args:
            stops: m, (n, k, 3), at most 16.
            reach: Distance from a stop within which the tool rests, m.
            again: One tour after another from end to end; otherwise one, from the nearest stop on.
            rests: False: to come within reach of a stop is enough.
            start_height: A TCP above that has not begun yet, m.
            gripper: See ``servo``.
            where: Environments that do it (n,); None: all.
        """
        points = np.ascontiguousarray(stops, np.float64)
        if points.ndim != 3 or points.shape[::2] != (self.n, 3):
            raise InvalidArgumentError(
                f"stops: shape {points.shape} given; ({self.n}, number of stops, 3) needed"
            )
        goal, rest = np.empty((self.n, 3)), np.empty(self.n, np.uint8)
        _core.tour(
            _readable(self.tcp_pos),
            _readable(self.qvel),
            _readable(self.elapsed),
            points,
            start_height,
            reach,
            again,
            rests,
            goal,
            rest,
        )
        moving = rest == 0
        chosen = moving if where is None else checked_mask(where, self.n) & moving
        self.rest(gripper=gripper, where=where)
        self.servo(goal, orientation=self.lean(goal), gripper=gripper, where=chosen)

    # --- goals ---

    def from_above(self, points: ArrayLike, clearance: float = 0.06) -> Reals:
        """Goals (n, 3): `clearance` above points until the TCP is nearly overhead, m."""
        out = np.empty((self.n, 3))
        goal = self._rows("points", points, 3)
        _core.approach_from_above(_readable(self.tcp_pos), goal, clearance, out)
        return out

    def descend(self, points: ArrayLike, travel_height: float) -> Reals:
        """Goals (n, 3): at a height of at most travel_height towards points, then down, m."""
        out = np.empty((self.n, 3))
        goal = self._rows("points", points, 3)
        _core.descend(_readable(self.tcp_pos), goal, travel_height, out)
        return out

    def lean(
        self,
        points: ArrayLike,
        *,
        orientation: ArrayLike = TOOL_DOWN,
        reach: float = 0.78,
        per_metre: float = 5.0,
        most: float = 0.4,
    ) -> Reals:
        """Orientations (n, 4), tilted outwards as far as points demand that are far away.

        Args:
            points: m, (3,) or (n, 3).
            orientation: (w, x, y, z) of the tool where nothing has to be tilted.
            reach: Distance from the axis of the robot's base from which on it tilts, m.
            per_metre: Angle for every metre beyond, rad/m.
            most: Greatest angle, rad.
        """
        out = np.empty((self.n, 4))
        base = self._rows("orientation", orientation, 4)
        _core.tilt_outwards(base, self._rows("points", points, 3), reach, per_metre, most, out)
        return out

    # --- guesses ---

    def guess(self, count: int, width: int = 1) -> NDArray[np.int64]:
        """Whole numbers from 0 to count - 1 for ``blind``: (n,), or (n, width).

        They are the same in every step of an episode.
        """
        chosen = (self.uniforms(width) * count).astype(np.int64)
        return chosen[:, 0] if width == 1 else chosen

    def guess_order(self, count: int) -> NDArray[np.int64]:
        """The numbers from 0 to count - 1 in a random order for ``blind``: (n, count)."""
        return self.uniforms(count).argsort(axis=1, kind="stable")

    def guess_choice(self) -> NDArray[np.int64]:
        """Numbers in ``choices`` for ``blind``: (n,), or (n, choice_count).

        Those that the caller has named (``ask`` and ``answer`` of environments), otherwise guesses.
        """
        guessed = self.guess_order(len(self.choices))[:, : self.choice_count]
        chosen = np.where(self.choice[:, :1] < 0, guessed, self.choice)
        return chosen[:, 0] if self.choice_count == 1 else chosen

    def uniforms(self, count: int) -> Reals:
        """Random numbers from 0 to 1 for ``blind``, the same in every step: (n, count)."""
        out = np.empty((self.n, count))
        _core.uniforms(_readable(self.policy_key), _readable(self.episode), count, out)
        return out

    # --- arrays for the engine ---

    def _write(self, out: NDArray[np.float32], where: Mask | None) -> None:
        if where is None:
            self.actions[:] = out
        else:
            np.copyto(self.actions, out, where=checked_mask(where, self.n)[:, None])

    def _rows(self, name: str, value: ArrayLike, width: int) -> Reals:
        given = np.asarray(value, np.float64)
        if given.shape not in ((width,), (self.n, width)):
            raise InvalidArgumentError(
                f"{name}: shape {given.shape} given; ({width},) or ({self.n}, {width}) needed"
            )
        return np.ascontiguousarray(np.broadcast_to(given, (self.n, width)))

    def _each(self, name: str, value: ArrayLike) -> Reals:
        given = np.asarray(value, np.float64)
        if given.shape not in ((), (self.n,)):
            raise InvalidArgumentError(
                f"{name}: shape {given.shape} given; a number or ({self.n},) needed"
            )
        return np.ascontiguousarray(np.broadcast_to(given, (self.n,)))


def _readable(view: NDArray[Any]) -> NDArray[Any]:
    """A contiguous array."""
    return np.ascontiguousarray(view)
