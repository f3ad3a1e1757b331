"""What the numbers of state and actions mean to a server, and what they mean here.

Here, proprio is TCP position (m), roll, pitch, yaw (rad, about fixed axes), opening of the gripper
(m); an action of pd_ee_delta_pose is translation in 0.1 m, rotation in -0.1 rad (as a rotation
vector about the world's axes), gripper from -1 (closed) to 1 (open).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from engram.datasets.spaces import continuous
from engram.errors import InvalidArgumentError

Array = npt.NDArray[Any]

_METRES, _RADIANS = 0.1, -0.1  # of one unit of an action
_OPEN = 0.08  # m, the gripper's largest opening


def known(what: str, name: Any, table: Mapping[str, Any]) -> str:
    """The name, if the table has it."""
    if not isinstance(name, str) or name not in table:
        raise InvalidArgumentError(f"{what}: {name!r} given, {', '.join(table)} allowed")
    return name


# --- rotations ---


def matrix_of(angles: Array) -> Array:
    """Rotation matrices (..., 3, 3) of roll, pitch, yaw about fixed axes."""
    (cr, cp, cy), (sr, sp, sy) = (np.moveaxis(f(angles), -1, 0) for f in (np.cos, np.sin))
    rows = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return np.stack([np.stack(row, -1) for row in rows], -2)


def rotation_vector(angles: Array) -> Array:
    """Rotation vectors (..., 3), 0 to pi long, of roll, pitch, yaw about fixed axes."""
    turn = quaternion(angles)
    return _vector_of(np.where(turn[..., :1] < 0, -turn, turn))


def quaternion(angles: Array) -> Array:
    """Quaternions (..., 4), w first, of roll, pitch, yaw about fixed axes."""
    half = np.asarray(angles, np.float64) / 2
    (cr, cp, cy), (sr, sp, sy) = (np.moveaxis(f(half), -1, 0) for f in (np.cos, np.sin))
    parts = [
        cy * cp * cr + sy * sp * sr,
        cy * cp * sr - sy * sp * cr,
        cy * sp * cr + sy * cp * sr,
        sy * cp * cr - cy * sp * sr,
    ]
    return np.stack(parts, -1)


def next_rotation_vector(angles: Array, before: Array | None) -> Array:
    """The rotation vector (3), 0 to 2 pi long, of a frame's roll, pitch, yaw.

    before: that of the frame before. The quaternion goes on from there, as that of a simulated
    robot does; the first one has x > 0, as of a hand that points down.
    """
    turn = quaternion(angles)
    along = turn[1] if before is None else turn @ _quaternion_of(before)
    return _vector_of(-turn if along < 0 else turn)


def _vector_of(turn: Array) -> Array:
    axis, sine = turn[..., 1:], np.linalg.norm(turn[..., 1:], axis=-1, keepdims=True)
    angle = 2 * np.arctan2(sine, turn[..., :1])
    return axis * np.where(sine > 1e-12, angle / np.maximum(sine, 1e-12), 2.0)


def _quaternion_of(vector: Array) -> Array:
    half = np.linalg.norm(vector) / 2
    return np.append(np.cos(half), np.sinc(half / np.pi) / 2 * vector)


# --- state ---


def _libero8(proprio: Array, before: Array | None) -> Array:
    """Position, rotation vector, both fingers (the right one negative), as of LIBERO."""
    turn = next_rotation_vector(proprio[3:6], None if before is None else before[3:6])
    return np.concatenate([proprio[:3], turn, proprio[6:] / 2, -proprio[6:] / 2])


def _libero_rpy8(proprio: Array, _: Array | None) -> Array:
    """The pose with angles that do not jump, and both fingers."""
    return np.concatenate([continuous(proprio)[:6], proprio[6:] / 2, -proprio[6:] / 2])


def _oxe8(proprio: Array, _: Array | None) -> Array:
    """Position, angles that do not jump, 0, gripper from 0 (closed) to 1 (open), as of Open X."""
    return np.concatenate([continuous(proprio)[:6], [0], proprio[6:] / _OPEN])


# Functions of a frame's proprio and of the state of the frame before, None in the first one.
LAYOUTS: dict[str, Callable[[Array, Array | None], Array]] = {
    "tcp7": lambda proprio, _: proprio,
    "tcp7_continuous": lambda proprio, _: continuous(proprio),
    "libero8": _libero8,
    "libero_rpy8": _libero_rpy8,
    "oxe8": _oxe8,
    "joints8": lambda proprio, _: proprio,
}
_OF_TCP = [name for name in LAYOUTS if name != "joints8"]
JOINTS = 8  # numbers of joint_proprio: seven angles and the gripper's width


def state_of(layout: str, proprio: Array, before: Array | None = None) -> Array:
    """A frame's proprio (7 or 8) in that layout, float32; before: the state of the frame before."""
    joints = proprio.shape[-1] == JOINTS
    if joints != (layout == "joints8"):
        given = "joint angles" if joints else "the TCP's pose"
        need = "joint angles" if layout == "joints8" else "the TCP's pose"
        raise InvalidArgumentError(
            f"state {layout}: {need} needed, and policies get {given} here; "
            + (
                "joints8"
                if joints
                else f"{', '.join(_OF_TCP)}, or joint_proprio (--joint-proprio),"
            )
            + " allowed"
        )
    return LAYOUTS[layout](np.asarray(proprio, np.float32), before).astype(np.float32)


# --- actions ---


@dataclasses.dataclass(frozen=True)
class Convention:
    """Meaning of an action's seven numbers: displacement of the TCP, and gripper.

    metres: of one unit of translation.
    radians: of one unit of rotation.
    euler: the rotation is roll, pitch, yaw about fixed axes, instead of a rotation vector.
    closed, open: values of the gripper.
    """

    metres: float
    radians: float
    euler: bool
    closed: float
    open: float


ACTIONS: dict[str, Convention | None] = {
    "mikasa": None,  # as they are
    "libero": Convention(0.05, 0.5, False, closed=1, open=-1),  # robosuite's OSC_POSE
    "oxe": Convention(1, 1, True, closed=0, open=1),  # metres and radians, as OpenVLA gives them
}


def to_engram(convention: str, actions: Array) -> Array:
    """Actions (..., 7) of a server as actions of pd_ee_delta_pose."""
    meaning = ACTIONS[convention]
    if meaning is None:
        return actions
    if actions.shape[-1] != 7:
        raise InvalidArgumentError(
            f"actions {convention}: {actions.shape[-1]} numbers given, 7 needed"
        )
    turn = actions[..., 3:6] * meaning.radians
    if meaning.euler:
        turn = rotation_vector(turn)
    share = (actions[..., 6:] - meaning.closed) / (meaning.open - meaning.closed)
    parts = [actions[..., :3] * (meaning.metres / _METRES), turn / _RADIANS, 2 * share - 1]
    return np.concatenate(parts, -1)


def from_engram(convention: str, actions: Array) -> Array:
    """The inverse of ``to_engram``, for servers of ours."""
    meaning = ACTIONS[convention]
    if meaning is None:
        return actions
    if meaning.euler:
        raise InvalidArgumentError(f"actions {convention}: mikasa or libero needed to serve")
    share = (actions[..., 6:] + 1) / 2
    parts = [
        actions[..., :3] * (_METRES / meaning.metres),
        actions[..., 3:6] * (_RADIANS / meaning.radians),
        meaning.closed + share * (meaning.open - meaning.closed),
    ]
    return np.concatenate(parts, -1)
