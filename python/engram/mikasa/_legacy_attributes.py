"""Attributes of the original's environments, computed from values that the core has."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from engram.mikasa import _families
from engram.mikasa._protocols import StateSource
from engram.mikasa._torch import torch
from engram.mikasa.agent import Pose

# Bodies in the original's scene, and positions that it stores.
_BODIES = frozenset(
    [
        *("table_scene", "cubes", "shape_actors", "mugs", "batteries", "mug_left"),
        *("mug_center", "mug_right", "red_ball", "goal_site", "disc", "cube", "blue_cube"),
        *("red_cube", "green_cube", "peg", "ball", "goal_region", "green_disc", "red_disc"),
        *("button_xy", "button_top_z", "initial_poses", "tray_slot_positions", "socket_slot_pos"),
    ]
)
_STATES = ("state", "state_dict")


class Actor:
    """A body whose pose is in the state observation."""

    def __init__(self, env: StateSource, name: str) -> None:
        self._env = env
        self.name = name

    @property
    def pose(self) -> Pose:
        """Present pose."""
        return Pose(torch.from_numpy(_field(self._env, f"{self.name}_pose").copy()))


def attribute(base: StateSource, name: str) -> Any:
    """An attribute computed from several values of the core; None if it is no such attribute.

    Raises:
        AttributeError: The original has it, and here it is not available; the message says why.
    """
    families, make = _MAKERS.get(name, ((), _nothing))
    return make(base) if base._family in families else None


def of_state(base: StateSource, name: str) -> Any:
    """A field of the state row, or a body whose pose is one; None if it is neither.

    Raises:
        AttributeError: The original has it, and here it is not available; the message says why.
    """
    if base.obs_mode in _STATES and name in _fields(base):
        return torch.from_numpy(_field(base, name).copy())
    if name not in _BODIES:
        return None
    if base.obs_mode in _STATES and f"{name}_pose" in _fields(base):
        return Actor(base, name)
    poses = ", ".join(one for one in _fields(base) if one.endswith(("_pose", "_pos", "_xy")))
    raise AttributeError(
        f"{name!r} is a body of the original's scene, or a position of one; engram has poses in "
        f"the observation modes state and state_dict: {poses}"
    )


def _fields(base: StateSource) -> dict[str, slice]:
    """Columns of the state row by name."""
    return {
        field["name"]: slice(field["offset"], field["offset"] + field["width"])
        for field in base._description["state_fields"]
    }


def _field(base: StateSource, name: str) -> np.ndarray:
    row: np.ndarray = base._env._views["observation"]
    return row[:, _fields(base)[name]]


def _waypoints(base: StateSource) -> torch.Tensor:
    """(B, W, 2); of sequences (B, shapes, W, 2), 0 after the last shape."""
    drawn = base._view("waypoints")
    assert drawn is not None
    shape: tuple[int, ...] = (-1, base.NUM_WAYPOINTS, 2)
    if base._family == "TraceShapeSeq":
        shape = (-1, base.MAX_SEQUENCE_LENGTH, *shape[1:])
    return torch.from_numpy(drawn.reshape(shape).copy())


def _checkpoints(base: StateSource) -> torch.Tensor:
    """Waypoints at a constant stride, from the first."""
    stride = base.NUM_WAYPOINTS // base.NUM_CHECKPOINTS
    return _waypoints(base)[..., : stride * base.NUM_CHECKPOINTS : stride, :].contiguous()


def _shape_closed(base: StateSource) -> torch.Tensor:
    """Shapes of a sequence that have been traced, bool (B, shapes)."""
    views = base._env._views
    count = np.rint(views["sequence_progress"] * base._view("sequence_len"))
    return torch.from_numpy(np.arange(base.MAX_SEQUENCE_LENGTH) < count[:, np.newaxis])


def _visited(base: StateSource) -> torch.Tensor:
    """Visited checkpoints of a single shape, as infos have them."""
    if base._family == "TraceShapeSeq":
        raise AttributeError(
            "'checkpoint_visited': for sequences engram has the number of visited checkpoints of "
            "the active shape, not which: active_visit_fraction, shape_closed"
        )
    return torch.from_numpy(base._env._views["checkpoint_visited"].copy())


def _touched_cubes(base: StateSource) -> torch.Tensor:
    """Cubes that have been touched, bool (B, cubes)."""
    if base.obs_mode not in _STATES:
        raise AttributeError(
            f"'touched_cubes': obs_mode {base.obs_mode} given; engram has it in state and "
            "state_dict"
        )
    names = [name for name in _fields(base) if name.startswith("touched_")]
    return torch.from_numpy(np.concatenate([_field(base, name) > 0 for name in names], axis=1))


def _colors(base: StateSource) -> dict[int, np.ndarray]:
    """Colours by number, red, green, blue and alpha from 0 to 1."""
    mapping = base.COLOR_MAPPING
    return {key: np.array(mapping[key][1]) / 255 for key in list(mapping)[: base.COLORS]}


def _nothing(base: StateSource) -> None:
    return None


_MAKERS: dict[str, tuple[tuple[str, ...], Callable[[StateSource], Any]]] = {
    "waypoints": (_families.TRACE, _waypoints),
    "checkpoints": (_families.TRACE, _checkpoints),
    "checkpoint_visited": (_families.TRACE, _visited),
    "shape_closed": (("TraceShapeSeq",), _shape_closed),
    "touched_cubes": (_families.CAPACITY, _touched_cubes),
    "color_dict": ((*_families.COLORS, *_families.CAPACITY), _colors),
}
