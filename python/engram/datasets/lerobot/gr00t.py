"""What Isaac-GR00T reads beside LeRobotDataset v2.1: meta/modality.json and annotation columns."""

from __future__ import annotations

from typing import Any

from engram.datasets.lerobot import layout
from engram.datasets.spaces import Spaces

DESCRIPTION = "human.task_description"
ANNOTATION = f"annotation.{DESCRIPTION}"  # column: index of the instruction in tasks.jsonl

# Parts that belong together, by the names of their first and last numbers.
_PARTS = (
    ("position", ("x", "delta_x"), ("z", "delta_z")),
    ("rotation", ("roll", "rotation_x"), ("yaw", "rotation_z")),
    ("joint_position", ("joint1", "delta_joint1"), ("joint7", "delta_joint7")),
    ("joint_velocity", ("velocity_joint1",), ("velocity_joint7",)),
    ("gripper", ("gripper",), ("gripper",)),
)


def modality(spaces: Spaces) -> dict[str, Any]:
    """The document modality.json."""
    action = _slices(spaces.action_names)
    for name, part in action.items():
        if name != "gripper" and part["end"] > spaces.absolute:
            part["absolute"] = False  # a change, or a velocity
    state = _slices(spaces.proprio_names)
    if "rotation" in state:
        state["rotation"]["rotation_type"] = "euler_angles_rpy"
    return {
        "state": state,
        "action": action,
        "video": {
            name: {"original_key": key}
            for name, key in zip(("image", "wrist_image"), layout.CAMERAS)
        },
        "annotation": {DESCRIPTION: {}},
    }


def _slices(names: tuple[str, ...]) -> dict[str, dict[str, Any]]:
    """[start, end) of the parts that are among the names."""
    found: dict[str, dict[str, Any]] = {}
    for part, first, last in _PARTS:
        starts = [names.index(name) for name in first if name in names]
        ends = [names.index(name) + 1 for name in last if name in names]
        if starts and ends:
            found[part] = {"start": starts[0], "end": ends[0]}
    return found
