"""Wrappers of observations: fixed scales, objects in a stable order, the time that is left."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Dict
from gymnasium.vector.utils import batch_space

from engram.errors import InvalidArgumentError
from engram.wrappers import numbers
from engram.wrappers.base import Wrapper, fields_of, horizons
from engram.wrappers.numbers import ANGLE, FINGER, HIDDEN, LENGTH, LIMIT, SPEED, TURN_RATE

REST = np.array(numbers.REST)
REST_TCP = np.array(numbers.REST_TCP)
# Units of arm and fingers, and those of their rows in the mode "objects", rad and m.
JOINTS = np.array([ANGLE] * 7 + [FINGER] * 2)
OBJECTS_JOINTS = np.array([np.pi] * 7 + [FINGER] * 2)

# Names of rows beside pictures.
_ROWS = ("state", "objects")
_EXCLUSIVE = re.compile(r"goal_\d+_pose")
_TOKEN = re.compile(r"object_(\d+)_(\w+)")


def has_rows(env: Any) -> bool:
    """Whether observations are rows, or have rows beside pictures."""
    space = env.single_observation_space
    if isinstance(space, Dict):
        return any(name in space.spaces for name in _ROWS)
    return isinstance(space, Box) and len(space.shape) == 1 and space.shape[0] > 0


class RowWrapper(Wrapper):
    """A wrapper of rows: modes "state" and "objects", also beside pictures, or another's rows."""

    def __init__(self, env: Any) -> None:
        super().__init__(env)
        space = env.single_observation_space
        if not has_rows(env):
            raise InvalidArgumentError(
                f"env: observations {space} given, rows needed: obs_mode='state' or 'objects'"
            )
        # Name of the rows beside pictures.
        self._key = next(n for n in _ROWS if n in space.spaces) if isinstance(space, Dict) else None

    def rows(self, rows: Any, info: dict[str, Any], began: np.ndarray) -> Any:
        """The rows for those of the batch inside."""
        raise NotImplementedError

    def observation(self, rows: Any, info: dict[str, Any], began: np.ndarray) -> Any:
        if self._key is None:
            return self.rows(rows, info, began)
        return {**rows, self._key: self.rows(rows[self._key], info, began)}

    def _row_space(self) -> Any:
        space: Any = self.single_observation_space
        return space if self._key is None else space[self._key]

    def _set_row_space(self, box: Box) -> None:
        space: Any = self.single_observation_space
        space = box if self._key is None else Dict({**space.spaces, self._key: box})
        self.single_observation_space = space
        self.observation_space = batch_space(space, self.num_envs)

    def _set_fields(self, fields: list[tuple[str, int]], limit: float) -> None:
        self._fields, offset = [], 0
        for name, width in fields:
            self._fields.append({"name": name, "offset": offset, "width": width, "unit": ""})
            offset += width
        self._set_row_space(Box(-limit, limit, (offset,), np.float32))

    @property
    def fields(self) -> list[dict[str, Any]]:
        return self._fields


class ScaleState(RowWrapper):
    """Brings a state row to numbers about 1, by the units of its fields: fixed, not learnt.

    * joints: distance from the rest pose / 0.5 rad, fingers / 0.04 m; joint speeds / 1 rad/s;
    * tcp_pose: position from that of the rest pose / 0.1 m, and the quaternion;
    * positions, the task's own poses included: vector from the TCP / 0.1 m; then the quaternion, if
      there is one, and 1 if the thing is there, else zeros: nothing is 1000 m away;
    * goal_<i>_pose, of which all but one are zero: their sum, as one position;
    * differences of positions / 0.1 m, with the same 1 or 0; speeds / 0.5 m/s; angles / 0.5 rad;
      control steps / the horizon; other numbers as they are.

    All are clipped to -10 to 10.

    Args:
        env: A batch with ``obs_mode="state"``, or that with pictures.
    """

    def __init__(self, env: Any) -> None:
        super().__init__(env)
        fields = fields_of(env)
        names = [field["name"] for field in fields]
        if "tcp_pose" not in names or any(_TOKEN.fullmatch(name) for name in names):
            raise InvalidArgumentError("env: another observation mode given, 'state' needed")
        self._tcp = _columns(next(f for f in fields if f["name"] == "tcp_pose"))
        self._parts = [(_part(f), f) for f in fields if not _EXCLUSIVE.fullmatch(f["name"])]
        self._goals = [_columns(f) for f in fields if _EXCLUSIVE.fullmatch(f["name"])]
        self._steps = float(horizons(env).max())
        out = [(f["name"], _WIDTHS.get(part, 0) + f["width"]) for part, f in self._parts]
        self._set_fields(out + [("goal_pose", 4)] * bool(self._goals), LIMIT)

    def rows(self, rows: Any, info: dict[str, Any], began: np.ndarray) -> Any:
        return self._scaled(rows)

    def final_observation(self, rows: Any, info: Any, ended: np.ndarray) -> Any:
        return self._scaled(rows)

    def _scaled(self, rows: np.ndarray) -> np.ndarray:
        tcp = rows[:, self._tcp][:, :3]
        parts = [self._scale(part, rows[:, _columns(field)], tcp) for part, field in self._parts]
        if self._goals:
            goal = np.sum([rows[:, columns] for columns in self._goals], axis=0)
            parts.append(_located(goal, tcp))
        return np.clip(np.concatenate(parts, 1), -LIMIT, LIMIT).astype(np.float32)

    def _scale(self, part: str, values: np.ndarray, tcp: np.ndarray) -> np.ndarray:
        if part == "joints":
            return (values - REST) / JOINTS
        if part == "tcp":
            return np.concatenate([(values[:, :3] - REST_TCP) / LENGTH, values[:, 3:]], 1)
        if part == "position":
            return _located(values, tcp)
        if part == "difference":
            return _located(values, np.zeros(3))
        return values / (self._steps if part == "control steps" else _UNITS[part])


_UNITS = {"": 1.0, "m": LENGTH, "rad": ANGLE, "m/s": SPEED, "rad/s": TURN_RATE}
# Columns that a part has beside its own.
_WIDTHS = {"position": 1, "difference": 1}


def _part(field: dict[str, Any]) -> str:
    """The kind of a field, by its name and unit."""
    name, unit, width = field["name"], field["unit"], field["width"]
    if name == "qpos":
        return "joints"
    if name == "tcp_pose":
        return "tcp"
    if unit == "m" and width in (3, 7):
        return "difference" if "_to_" in name else "position"
    return unit if unit in _UNITS or unit == "control steps" else "rad/s" if name == "qvel" else ""


def _columns(field: dict[str, Any]) -> slice:
    return slice(field["offset"], field["offset"] + field["width"])


def _located(values: np.ndarray, origin: np.ndarray) -> np.ndarray:
    """Position from an origin, what follows it, and whether it is there at all."""
    there = (np.abs(values[:, :3]) < HIDDEN).all(1) & values[:, :3].any(1)
    vector = (values[:, :3] - origin) / LENGTH
    parts = np.concatenate([vector, values[:, 3:], np.ones((len(values), 1))], 1)
    return np.where(there[:, None], parts, 0)


class ObjectRows(RowWrapper):
    """Objects in an order that lasts, with positions from the TCP, for a plain network.

    Tokens are ordered by kind, shape, colour, and from left to right (smaller y first), whenever
    other objects come into view; objects that cannot be seen are last. So the same objects have the
    same columns in all episodes, whatever the shuffled order of the observation. A token's position
    becomes the vector from the TCP to the object, in units of 0.1 m; "seen" is the mask. Joints
    count from the rest pose in units of 0.5 rad, the TCP's position from its own there; joint
    speeds are in rad/s.

    Args:
        env: A batch with ``obs_mode="objects"``, or that with pictures.
    """

    def __init__(self, env: Any) -> None:
        super().__init__(env)
        fields = fields_of(env)
        tokens = [f for f in fields if _TOKEN.fullmatch(f["name"])]
        if not tokens:
            raise InvalidArgumentError("env: another observation mode given, 'objects' needed")
        self._first = tokens[0]["offset"]
        parts = {f["name"].removeprefix("object_0_"): f for f in tokens if "t_0_" in f["name"]}
        self._token = {
            name: slice(f["offset"] - self._first, f["offset"] - self._first + f["width"])
            for name, f in parts.items()
        }
        self._width = sum(f["width"] for f in parts.values())
        self._count = len(tokens) // len(parts)
        own = {f["name"]: _columns(f) for f in fields if f["offset"] < self._first}
        self._qpos, self._qvel, self._tcp = own["qpos"], own["qvel"], own["tcp_pose"]
        self._order = np.tile(np.arange(self._count), (self.num_envs, 1))
        self._known = np.full((self.num_envs, self._count), -1.0)
        self._set_fields([(f["name"], f["width"]) for f in fields], LIMIT)

    def rows(self, rows: Any, info: dict[str, Any], began: np.ndarray) -> Any:
        tokens = self._tokens(rows)
        looks = self._looks(tokens)
        again = began | ((looks != self._known) & (looks >= 0)).any(1)
        if again.any():
            # Ties, such as equal cups, go from left to right.
            y = np.round(tokens[again][..., self._token["position"]][..., 1], 3)
            hidden = looks[again] < 0
            self._order[again] = np.lexsort((y, looks[again], hidden), axis=-1)
        self._known = looks
        return self._flat(rows, tokens, self._order)

    def final_observation(self, rows: Any, info: Any, ended: np.ndarray) -> Any:
        return self._flat(rows, self._tokens(rows), self._order[ended])

    def _tokens(self, rows: np.ndarray) -> np.ndarray:
        tokens: np.ndarray = rows[:, self._first :].reshape(len(rows), self._count, self._width)
        return tokens

    def _looks(self, tokens: np.ndarray) -> np.ndarray:
        """A number for the looks of each object, -1 for one that is not seen."""
        key = np.zeros(tokens.shape[:2])
        for name in ("kind", "shape", "color"):
            part = tokens[..., self._token[name]]
            key = 20 * key + np.where(part.any(-1), part.argmax(-1) + 1, 0)
        return np.where(tokens[..., self._token["seen"]][..., 0] > 0, key, -1)

    def _flat(self, rows: np.ndarray, tokens: np.ndarray, order: np.ndarray) -> np.ndarray:
        robot = np.array(rows[:, : self._first])
        robot[:, self._qpos] = (robot[:, self._qpos] * OBJECTS_JOINTS - REST) / JOINTS
        robot[:, self._qvel] *= np.pi / TURN_RATE
        tcp = robot[:, self._tcp][:, :3] * np.float32(0.5)
        robot[:, self._tcp.start : self._tcp.start + 3] = (tcp - REST_TCP) / LENGTH
        tokens = np.take_along_axis(tokens, order[..., None], 1)
        seen = tokens[..., self._token["seen"]]
        position = 0.5 * tokens[..., self._token["position"]] - tcp[:, None]
        tokens[..., self._token["position"]] = position / LENGTH * seen
        flat = np.concatenate([robot, tokens.reshape(len(rows), -1)], 1)
        return np.clip(flat, -LIMIT, LIMIT).astype(np.float32)


class TimeLeft(RowWrapper):
    """Adds the time that is left to the row: (H - t) / H after t of H steps.

    Args:
        env: A batch with rows as observations.
    """

    def __init__(self, env: Any) -> None:
        super().__init__(env)
        inner = self._row_space()
        self._horizons = horizons(env)
        fields = fields_of(env)
        width = inner.shape[0]
        self._fields = [*fields, {"name": "time_left", "offset": width, "width": 1, "unit": ""}]
        self._set_row_space(
            Box(np.append(inner.low, np.float32(0)), np.append(inner.high, np.float32(1)))
        )

    def rows(self, rows: Any, info: dict[str, Any], began: np.ndarray) -> Any:
        return self._with(rows, info["elapsed_steps"], self._horizons)

    def final_observation(self, rows: Any, info: Any, ended: np.ndarray) -> Any:
        if isinstance(info, dict):
            elapsed = info["elapsed_steps"][ended]
        else:  # Gymnasium 0.29
            elapsed = np.array([one["elapsed_steps"] for one in info[ended]])
        return self._with(rows, elapsed, self._horizons[ended])

    def _with(self, rows: Any, elapsed: np.ndarray, horizon: np.ndarray) -> np.ndarray:
        left = ((horizon - elapsed) / horizon).astype(np.float32)
        return np.concatenate([rows, left[:, None]], 1)
