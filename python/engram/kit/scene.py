"""Placing, hiding, moving and measuring props in many environments at once."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engram import _core
from engram.errors import InvalidArgumentError
from engram.kit.functions import length, tanh
from engram.kit.props import rgba

HIDDEN_HEIGHT = 1000.0  # m: where a hidden prop is reported
_HIDDEN, _ASLEEP, _AWAKE = 0, 1, 2
_POSED, _ONLY_CONTACTS = 1, 2  # in the column moved
_ARM_JOINTS = 7

Mask = NDArray[np.bool_]


class Props:
    """A group of props with successive indices: ``Task.add_props`` returns it."""

    def __init__(self, first: int, count: int) -> None:
        self.first = first
        self.slice = slice(first, first + count)

    def __len__(self) -> int:
        return self.slice.stop - self.slice.start

    def __iter__(self) -> Iterator[int]:
        return iter(range(self.slice.start, self.slice.stop))

    @overload
    def __getitem__(self, which: int) -> int: ...
    @overload
    def __getitem__(self, which: NDArray[Any]) -> NDArray[Any]: ...
    def __getitem__(self, which: Any) -> Any:
        """The index of one prop in the scene, or one index for every environment."""
        if isinstance(which, np.ndarray):
            return which + self.first
        return range(self.slice.start, self.slice.stop)[which]

    def __repr__(self) -> str:
        return f"Props({self.slice.start} to {self.slice.stop - 1})"


def checked_mask(where: Any, n: int) -> Mask:
    """A choice of environments."""
    given = np.asarray(where)
    if given.shape != (n,) or given.dtype != np.bool_:
        raise InvalidArgumentError(
            f"where: {given.dtype} of shape {given.shape} given; bool of shape ({n},) needed"
        )
    return given


# One prop, one in every environment (n,), or a group.
AnyProps = int | NDArray[np.integer[Any]] | Props


class Scene:
    """Base of ``Task`` with what moves, paints and measures."""

    n: int
    rows: NDArray[np.int64]
    elapsed: NDArray[np.int32]
    action: NDArray[np.float32]
    previous_action: NDArray[np.float32]
    tcp_pos: NDArray[np.float64]
    tcp_quat: NDArray[np.float64]
    qvel: NDArray[np.float64]
    prop_pos: NDArray[np.float64]
    prop_quat: NDArray[np.float64]
    prop_qvel: NDArray[np.float64]
    prop_status: NDArray[np.uint8]
    prop_rgba: NDArray[np.float32]
    prop_emission: NDArray[np.float32]
    finger_force: NDArray[np.float64]
    moved: NDArray[np.uint8]
    success: NDArray[np.bool_]
    answer: str
    answered: NDArray[np.bool_]
    first_answer: NDArray[np.int32]
    first_answer_correct: NDArray[np.bool_]

    _upright: NDArray[np.float64]  # (props, 4)
    _resting_height: NDArray[np.float64]  # (props), NaN: unknown

    # --- poses ---

    def place(
        self,
        props: AnyProps,
        pos: ArrayLike,
        quat: ArrayLike | None = None,
        *,
        where: Mask | None = None,
        awake: bool = False,
        velocity: ArrayLike | None = None,
        spin: ArrayLike | None = None,
    ) -> None:
        """Puts props into the scene, at rest unless a velocity is given.

        Values are the same for all environments, such as (3,), or have a row for each, such as
        (n, 3); for a group of k props (k, 3) or (n, k, 3).

        Args:
            props: A prop, a group, or an index for every environment (n,).
            pos: x, y and z, m; or x and y of props that stand on the table.
            quat: (w, x, y, z); None: upright.
            where: Environments in which it is done (n,); None: all.
            awake: The prop hangs in the air or touches something that moves: physics acts at once.
                Other props are at rest until something comes near them.
            velocity: m/s along the world's axes; of dynamic props, with awake=True.
            spin: rad/s about the body's axes; the same.
        """
        chosen = self._choose(props, where)
        if chosen is None:
            return
        index, group = chosen
        self._set_pos("place", index, group, pos, where)
        if quat is None:
            self.prop_quat[index] = self._upright[index[1]]
        else:
            self.prop_quat[index] = self._values("place: quat", quat, 4, group, where)
        self.prop_qvel[index] = 0
        for first, value in ((0, velocity), (3, spin)):
            if value is not None:
                name = "place: spin" if first else "place: velocity"
                moved = self._values(name, value, 3, group, where)
                self.prop_qvel[(*index, slice(first, first + 3))] = moved
        self.prop_status[index] = _AWAKE if awake else _ASLEEP
        self.moved[index] = _POSED

    def hide(
        self, props: AnyProps, *, where: Mask | None = None, pos: ArrayLike | None = None
    ) -> None:
        """Takes props out of the scene.

        Args:
            props: A prop, a group, or an index for every environment (n,).
            where: Environments in which it is done (n,); None: all.
            pos: What is reported as their position, m; None: 1000 m above the origin.
        """
        chosen = self._choose(props, where)
        if chosen is None:
            return
        index, group = chosen
        if pos is None:
            self.prop_pos[index] = (0.0, 0.0, HIDDEN_HEIGHT)
        else:
            self.prop_pos[index] = self._values("hide: pos", pos, 3, group, where)
        self.prop_quat[index] = (1.0, 0.0, 0.0, 0.0)
        self.prop_qvel[index] = 0
        self.prop_status[index] = _HIDDEN
        self.moved[index] = _POSED

    def move(self, props: AnyProps, pos: ArrayLike, *, where: Mask | None = None) -> None:
        """Moves kinematic or visual props to a position over this step, in ``before_physics``.

        They push what they meet; ``place`` would put them there at once.
        """
        chosen = self._choose(props, where)
        if chosen is None:
            return
        index, group = chosen
        goal = self._values("move: pos", pos, 3, group, where)
        self.prop_qvel[(*index, slice(0, 3))] = goal - self.prop_pos[index]
        self.prop_status[index] = _AWAKE

    def forget_contacts(self, props: AnyProps, *, where: Mask | None = None) -> None:
        """Lets physics find contact points anew, as where a pose is set to what it is.

        The original benchmark does that in every step for some props, which makes a difference in
        the last digits of what touches them. Other tasks need it not.
        """
        chosen = self._choose(props, where)
        if chosen is not None:
            self.moved[chosen[0]] = _ONLY_CONTACTS

    def paint(
        self,
        props: AnyProps,
        color: Any,
        *,
        where: Mask | None = None,
        emission: float | None = None,
    ) -> None:
        """Gives props another colour in images.

        Args:
            props: A prop, a group, or an index for every environment (n,).
            color: A name, 3 or 4 numbers, or 4 numbers for every environment (n, 4); None: the
                prop's own.
            where: Environments in which it is done (n,); None: all.
            emission: Emitted light, 0 to 1; None: as it is.
        """
        chosen = self._choose(props, where)
        if chosen is None:
            return
        index, group = chosen
        if color is None:
            self.prop_rgba[index] = 0
        elif isinstance(color, np.ndarray) and color.ndim > 1:
            self.prop_rgba[index] = self._values("paint: color", color, 4, group, where)
        else:
            self.prop_rgba[index] = rgba("paint: color", color)
        if emission is not None:
            self.prop_emission[index] = emission

    # --- measures ---

    def pos_of(self, props: AnyProps) -> NDArray[np.float64]:
        """Positions, m: (n, 3), of a group (n, k, 3)."""
        if isinstance(props, Props):
            return self.prop_pos[:, props.slice]
        if isinstance(props, np.ndarray):
            return self.prop_pos[self.rows, props]
        return self.prop_pos[:, props]

    def tcp_distance(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Distance of the TCP from points, m: (n, 3) becomes (n,), (n, k, 3) becomes (n, k)."""
        tcp = self.tcp_pos if points.ndim < 3 else self.tcp_pos[:, None]
        return length(tcp - points)

    def nearest(
        self, points: NDArray[np.float64], radius: float, *, where: Mask | None = None
    ) -> NDArray[np.int64]:
        """The point (n, k, 3) nearest to the TCP, if within radius, m: (n,), otherwise -1."""
        found = np.full(self.n, -1)
        rows = self.rows if where is None else checked_mask(where, self.n).nonzero()[0]
        if len(rows) == 0:
            return found
        away = length(self.tcp_pos[rows, None] - points[rows])
        nearest = away.argmin(axis=1)
        within = away[np.arange(len(rows)), nearest] <= radius
        found[rows[within]] = nearest[within]
        return found

    def robot_is_static(self, speed: float = 0.2) -> Mask:
        """Whether no joint of the arm is faster, rad/s: (n,)."""
        arm = self.qvel.T[:_ARM_JOINTS].copy()
        return np.abs(arm, out=arm).max(axis=0) <= speed

    def prop_is_static(self, props: AnyProps, speed: float = 1e-2, spin: float = 1e-1) -> Mask:
        """Whether props are slower than that, m/s and rad/s: (n,), of a group (n, k)."""
        if isinstance(props, Props):
            qvel = self.prop_qvel[:, props.slice]
        else:
            qvel = self.prop_qvel[self.rows, props]
        return (length(qvel[..., :3]) <= speed) & (length(qvel[..., 3:]) <= spin)

    def is_grasping(self, prop: int, force: float = 0.5, angle: float = 85.0) -> Mask:
        """Whether both fingers press on a prop: (n,).

        Args:
            prop: Its index.
            force: Least force of each finger, N.
            angle: Most between force and opening direction, degrees.
        """
        out = np.empty(self.n, np.uint8)
        _core.is_grasping(self.tcp_quat, self.finger_force, int(prop), force, angle, out)
        return out.view(np.bool_)

    def smoothness_penalty(self, action: float, change: float, speed: float) -> NDArray[np.float64]:
        """The benchmark's penalty on large and abrupt actions: (n,).

        Args:
            action: Weight of tanh(2 a), a being the action's norm.
            change: Weight of tanh(5 c), c being the norm of its change; 0 in the first step.
            speed: Weight of tanh(2 v), v being the norm of the arm joints' velocities.
        """
        changed = length(self.action - self.previous_action) * (self.elapsed > 1)
        arm = length(self.qvel[:, :_ARM_JOINTS])
        return (
            action * tanh(2.0 * length(self.action).astype(np.float64))
            + change * tanh(5.0 * changed.astype(np.float64))
            + speed * tanh(2.0 * arm)
        )

    def give_answer(self, value: ArrayLike, correct: ArrayLike, where: Mask) -> None:
        """Records the robot's answer; only the first one of an episode counts.

        Args:
            value: Its number, (n,).
            correct: Whether it is the right one, (n,).
            where: Environments in which it is given (n,).
        """
        given = where & ~self.answered
        if given.any():
            np.copyto(self.first_answer, value, where=given, casting="same_kind")
            np.copyto(self.first_answer_correct, correct, where=given)
            self.answered |= given

    def answer_by_touch(
        self, points: NDArray[np.float64], right: NDArray[Any], radius: float, *, where: Mask
    ) -> None:
        """Writes success, and the answer, of tasks in which a point has to be touched.

        A touch is a TCP within radius of a point while the arm is static. The nearest point that
        is touched first is the answer.

        Args:
            points: (n, k, 3), m.
            right: Number of the right one, (n,).
            radius: m.
            where: Environments in which touches count (n,).
        """
        resting = checked_mask(where, self.n) & self.robot_is_static()
        self.success[:] = resting & (self.tcp_distance(points[self.rows, right]) <= radius)
        if self.answer:
            touched = self.nearest(points, radius, where=resting & ~self.answered)
            self.give_answer(touched, touched == right, touched >= 0)

    # --- indices and values ---

    def _choose(self, props: AnyProps, where: Mask | None) -> tuple[tuple[Any, Any], int] | None:
        """Indices of environments and props, and the size of a group or 0; None: nothing to do."""
        rows: Any = slice(None)
        if where is not None:
            rows = checked_mask(where, self.n).nonzero()[0]
            if len(rows) == 0:
                return None
        if isinstance(props, Props):
            return (rows, props.slice), len(props)
        if isinstance(props, (int, np.integer)):
            return (rows, props), 0
        given = np.asarray(props)
        if given.shape != (self.n,) or given.dtype.kind not in "iu":
            raise InvalidArgumentError(
                f"props: {given.dtype} of shape {given.shape} given; an index, a group of "
                f"add_props, or integers of shape ({self.n},) needed"
            )
        return (self.rows, given) if where is None else (rows, given[rows]), 0

    def _set_pos(
        self, name: str, index: Any, group: int, pos: ArrayLike, where: Mask | None
    ) -> None:
        given = np.asarray(pos, np.float64)
        if given.shape[-1:] != (2,):
            self.prop_pos[index] = self._values(f"{name}: pos", given, 3, group, where)
            return
        height = self._resting_height[index[1]]
        if np.isnan(height).any():
            raise InvalidArgumentError(f"{name}: x and y given, but the prop needs a height, too")
        flat = self._values(f"{name}: pos", given, 2, group, where)
        self.prop_pos[(*index, slice(0, 2))] = flat
        self.prop_pos[(*index, 2)] = height

    def _values(
        self, name: str, value: ArrayLike, width: int, group: int, where: Mask | None
    ) -> NDArray[np.float64]:
        """Values for the chosen props: the same everywhere, or the rows of `where`."""
        given = np.asarray(value, np.float64)
        each = (group, width) if group else (width,)
        if given.shape == (self.n, *each) and given.ndim == len(each) + 1:
            return given if where is None else given[where]
        if given.shape in (each, (width,)):
            return given
        if group and given.shape == (self.n, 1, width):
            return given if where is None else given[where]
        raise InvalidArgumentError(
            f"{name}: shape {given.shape} given; {each} or {(self.n, *each)} needed"
        )
