"""Where props stand: none is inside the table, and each is in some picture."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engram.kit import props as kinds
from engram.kit.buttons import CAP_HALF_HEIGHT
from engram.kit.checks.play import Player
from engram.kit.checks.subject import Subject

_TOLERANCE = 0.002  # m: what contacts allow
_UPRIGHT = 1e-6
_TABLE = ((-0.7245, 0.4845), (-1.209, 1.209))  # m: least and greatest x and y of a table that ends

Array = NDArray[np.float64]


class Placing:
    """What the episodes of a task show of its props."""

    def __init__(self, subject: Subject) -> None:
        self.subject = subject
        self.props = subject.tasks[-1]._declared.props
        self.shown = np.zeros(len(self.props), bool)
        self.overlaps: dict[str, tuple[float, int]] = {}  # m, and the step of the first one

    def note(self, step: int) -> None:
        """Looks at the latest batch."""
        if not self.props:
            return
        placed = self.subject.view("prop_status") != 0
        self.shown |= placed.any(axis=0)
        pos, quat = self.subject.view("prop_pos"), self.subject.view("prop_quat")
        for i, prop in enumerate(self.props):
            rows = placed[:, i] & self._is_over_table(pos[:, i])
            if getattr(prop, "body", "") == "visual" or not rows.any():
                continue
            depth = float(np.max(lowest(prop, quat[rows, i]) - pos[rows, i, 2], initial=0))
            if depth > _TOLERANCE and prop.name not in self.overlaps:
                self.overlaps[prop.name] = (depth, step)

    def report(self) -> None:
        """Says what is wrong with the props' places."""
        for name, (depth, step) in self.overlaps.items():
            self.subject.add(
                "runs", "wrong",
                f"prop {name!r} overlaps the table by {1000 * depth:.0f} mm in step {step}; "
                "place() takes the height of its origin, or x and y alone", depth=depth, step=step,
            )  # fmt: skip
        names = [prop.name for prop, shown in zip(self.props, self.shown) if not shown]
        for name in names:
            self.subject.add(
                "runs", "note",
                f"prop {name!r} is hidden in every step of all episodes; place() puts it there",
            )  # fmt: skip
        for prop in self._unpictured():
            self.subject.add(
                "runs", "wrong",
                f"prop {prop.name!r} is placed, but is in no picture of any episode; something "
                "covers it, or it is too small or out of the cameras' view",
            )  # fmt: skip

    def _is_over_table(self, pos: Array) -> Any:
        if not self.subject.tasks[-1].table_ends:
            return np.ones(len(pos), bool)
        (x0, x1), (y0, y1) = _TABLE
        x, y = pos[:, 0], pos[:, 1]
        return (x > x0) & (x < x1) & (y > y0) & (y < y1)

    def _unpictured(self) -> list[kinds.Prop]:
        """Props that are placed and visible, but are not in the images of some episodes."""
        count = 2 if self.subject.fast else 4
        pictured: set[int] = set()
        with self.subject.batch(count, obs_mode="rgb+segmentation") as env:
            names = env.description["segmentation_names"]
            player = Player(self.subject, env, self.subject.policy)
            player.begin(range(100, 100 + count))
            outputs = player.steps[-1]
            for step in range(self.subject.horizon + 1):
                pictured |= set(np.unique(outputs["segmentation"]).tolist())
                if step < self.subject.horizon:
                    outputs = player.step()
                    player.steps.clear()  # pictures of a whole episode need not stay
                    player.steps.append({})
        found = {names[index] for index in pictured}
        return [
            prop
            for prop, shown in zip(self.props, self.shown)
            if shown and prop.name not in found and _is_visible(prop)
        ]


def _is_visible(prop: kinds.Prop) -> bool:
    return not isinstance(prop, kinds.Parts) or any(geom.visible for geom in prop.geoms)


def lowest(prop: kinds.Prop, quat: Array) -> Array:
    """How far a prop reaches below its origin (n,), m, with orientations (n, 4).

    Negative infinity where that is not known: shapes and tilted furniture.
    """
    if isinstance(prop, (kinds.Sphere, kinds.Ball)):
        return np.full(len(quat), prop.radius)
    if isinstance(prop, kinds.Parts):
        parts = [_geom_reach(geom, quat) for geom in prop.geoms if geom.collides]
        return np.max(parts, axis=0) if parts else np.full(len(quat), -np.inf)
    up = _up_in_body(quat)
    if isinstance(prop, kinds.Cube):
        return _box_reach((prop.half_size,) * 3, up)
    if isinstance(prop, kinds.Box):
        return _box_reach(prop.half_size, up)
    if isinstance(prop, kinds.Cylinder):
        return _cylinder_reach(prop.radius, prop.half_height, up)
    if isinstance(prop, kinds.Mesh):
        return np.max(-up @ np.asarray(prop.vertices).T, axis=1)
    height = prop.resting_height
    if isinstance(prop, kinds.ButtonCap):
        height = CAP_HALF_HEIGHT  # it rests on its base
    upright = np.abs(quat @ np.asarray(prop.upright)) > 1 - _UPRIGHT
    return np.where(upright & (height is not None), -np.inf if height is None else height, -np.inf)


def _up_in_body(quat: Array) -> Array:
    """The world's z axis in the frames of bodies (n, 3)."""
    w, x, y, z = (quat / np.linalg.norm(quat, axis=1, keepdims=True)).T
    return np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=1)


def _box_reach(half_size: Any, up: Array) -> Array:
    return np.abs(up) @ np.asarray(half_size, float)


def _cylinder_reach(radius: float, half_height: float, up: Array) -> Array:
    along = np.abs(up[:, 2])
    return half_height * along + radius * np.sqrt(np.maximum(0, 1 - along**2))


def _geom_reach(geom: kinds.Geom, quat: Array) -> Array:
    """How far a part reaches below the origin of its prop (n,)."""
    up = _up_in_body(quat)
    own = up @ _rotation(np.asarray(geom.quat, float))
    size = [*(geom.size or ()), 0.0, 0.0, 0.0]
    if geom.type == "box":
        reach = _box_reach(size[:3], own)
    elif geom.type == "cylinder":
        reach = _cylinder_reach(size[0], size[1], own)
    elif geom.type == "capsule":
        reach = size[0] + size[1] * np.abs(own[:, 2])
    elif geom.type == "ellipsoid":
        reach = np.linalg.norm(own * size[:3], axis=1)
    elif geom.type == "sphere":
        reach = np.full(len(quat), size[0])
    else:
        return np.full(len(quat), -np.inf)
    return reach - up @ np.asarray(geom.pos, float)


def _rotation(quat: Array) -> Array:
    w, x, y, z = quat / np.linalg.norm(quat)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip
