"""What the numbers of states and actions are, by control mode and kind of proprio."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from engram.datasets import checks
from engram.datasets.checks import DatasetError

CONTROL_MODE = "pd_ee_delta_pose"  # the benchmark's
CONTROL_RATE = 20  # control steps, and frames, in a second
ANGLES = ("continuous", "benchmark")

_JOINTS = tuple(f"joint{i}" for i in range(1, 8))
_TCP = ("x", "y", "z", "roll", "pitch", "yaw")
_STEPS = ("delta_x", "delta_y", "delta_z")
_TURNS = ("rotation_x", "rotation_y", "rotation_z")
_DELTAS = tuple(f"delta_{name}" for name in _JOINTS)
_VELOCITIES = tuple(f"velocity_{name}" for name in _JOINTS)
_GRIPPER = "gripper"  # the last number of every action and proprio

# The arm's part of an action (docs/robot.md).
_ARM: dict[str, tuple[str, ...]] = {
    "pd_joint_delta_pos": _DELTAS,
    "pd_joint_pos": _JOINTS,
    "pd_ee_delta_pos": _STEPS,
    "pd_ee_delta_pose": _STEPS + _TURNS,
    "pd_ee_pose": _TCP,
    "pd_joint_target_delta_pos": _DELTAS,
    "pd_ee_target_delta_pos": _STEPS,
    "pd_ee_target_delta_pose": _STEPS + _TURNS,
    "pd_joint_vel": _VELOCITIES,
    "pd_joint_pos_vel": _JOINTS + _VELOCITIES,
    "pd_joint_delta_pos_vel": _DELTAS + _VELOCITIES,
}
_ABSOLUTE = {"pd_joint_pos": 7, "pd_ee_pose": 6, "pd_joint_pos_vel": 7}  # numbers beyond [-1, 1]
_ROLL, _YAW = 3, 5  # of the TCP's pose
# The hand points down, so roll is near pi. Yaw has a gap there, where joint 7 cannot turn to.
_LOWEST = {_ROLL: 0.0, _YAW: -0.75 * np.pi}


@dataclasses.dataclass(frozen=True)
class Spaces:
    """The spaces of one set of demonstrations."""

    control_mode: str = CONTROL_MODE
    joint_proprio: bool = False

    def __post_init__(self) -> None:
        if self.control_mode not in _ARM:
            raise DatasetError(
                f"control_mode: {checks.short(self.control_mode)} given; {', '.join(_ARM)} allowed"
            )
        if type(self.joint_proprio) is not bool:
            raise DatasetError(
                f"joint_proprio: {checks.short(self.joint_proprio)} given; true or false needed"
            )

    @classmethod
    def of_metadata(cls, document: dict[str, Any]) -> Spaces:
        """Those that metadata.json names; the benchmark's where it names none."""
        origin = document.get("engram", {})
        mode = origin.get("control_mode", CONTROL_MODE)
        return cls(mode if isinstance(mode, str) else "", origin.get("joint_proprio", False))

    def __str__(self) -> str:
        return f"{self.control_mode} and proprio of {'joints' if self.joint_proprio else 'the TCP'}"

    @property
    def action_names(self) -> tuple[str, ...]:
        return (*_ARM[self.control_mode], _GRIPPER)

    @property
    def proprio_names(self) -> tuple[str, ...]:
        return (*(_JOINTS if self.joint_proprio else _TCP), _GRIPPER)

    @property
    def absolute(self) -> int:
        """How many of the first numbers of an action are poses or angles, beyond [-1, 1]."""
        return _ABSOLUTE.get(self.control_mode, 0)

    def check_actions(self, what: str, values: np.ndarray) -> None:
        """Refuses what environments do not take."""
        checks.finite(what, values)
        checks.within_one(what, values[:, self.absolute :])

    def proprio(self, values: np.ndarray, angles: str) -> np.ndarray:
        """Rows of proprio with the angles in that form."""
        return values if self.joint_proprio or angles != ANGLES[0] else continuous(values)


def continuous(proprio: np.ndarray) -> np.ndarray:
    """Poses (..., 7) whose angles do not jump: roll from 0, yaw from -3/4 pi, to one turn more.

    The benchmark's roll flips between -pi and pi, because the hand points down. A number depends on
    its own frame only, so that a policy can be given the same.
    """
    changed = proprio.copy()
    for column, lowest in _LOWEST.items():
        angles = proprio[..., column].astype(np.float64)
        changed[..., column] = np.where(angles < lowest, angles + 2 * np.pi, angles)
    return changed
