"""Gymnasium spaces, and views of the observation, from the description of a batch."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping, Sequence
from copy import deepcopy
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.vector.utils import batch_space

from engram.typing import Field, TaskDescription

TOKEN = "object_"  # fields of the objects modes that begin like that are of a token
OBJECT_MASK = "object_mask"  # of batches of several tasks: the objects that a task has
ROW = "observation"  # output with the row of states or of objects
_ROWS = ("state", "objects")  # names of the row among the parts of an observation
FIRST_EXTRA_FIELD = "tcp_pose"  # of state_dict; those before it are "agent"


class ImageBox(spaces.Box):
    """Space of images: whole numbers from 0 on, by default all bytes.

    Its bounds are one number each, seen as arrays of its shape. Gymnasium's own would fill four
    arrays as large as the images, for a whole batch hundreds of megabytes. Everything else is as in
    a Box: equality, samples, copies and pickles.
    """

    def __init__(
        self, shape: Sequence[int], seed: Any = None, dtype: Any = np.uint8, most: int | None = None
    ):
        shape = tuple(int(size) for size in shape)
        self._most = int(np.iinfo(dtype).max) if most is None else most
        super().__init__(0, self._most, (1,), dtype, seed)
        self._set_shape(shape)

    def _set_shape(self, shape: tuple[int, ...]) -> None:
        self._shape = shape
        self.low_repr, self.high_repr = "0", str(self._most)
        for name in ("low", "high", "bounded_below", "bounded_above"):
            one = getattr(self, name).reshape(-1)[:1].copy()
            setattr(self, name, np.broadcast_to(one, shape))

    def contains(self, x: Any) -> bool:
        """True for images of this shape within the bounds."""
        if isinstance(x, np.ndarray) and self.dtype == np.uint8 and self._most == 255:
            return np.can_cast(x.dtype, np.uint8) and x.shape == self.shape
        return super().contains(x)

    def __eq__(self, other: Any) -> bool:
        if isinstance(other, ImageBox):
            return (self.shape, self.dtype, self._most) == (other.shape, other.dtype, other._most)
        return super().__eq__(other)

    def __reduce__(self) -> tuple[Any, ...]:
        return ImageBox, (self.shape, self.np_random, self.dtype, self._most)

    def __copy__(self) -> ImageBox:
        return self.of_shape(self.shape, self.np_random)

    def __deepcopy__(self, memo: dict[int, Any]) -> ImageBox:
        return self.of_shape(self.shape, deepcopy(self.np_random, memo))

    def of_shape(self, shape: Sequence[int], seed: Any) -> ImageBox:
        """The space's numbers in another shape."""
        return ImageBox(shape, seed, self.dtype, self._most)


@batch_space.register(ImageBox)
def _batch_image_box(space: ImageBox, n: int = 1) -> ImageBox:
    return space.of_shape((n, *space.shape), deepcopy(space.np_random))


class Layout:
    """Layout of observations in the outputs of a batch, and their spaces.

    Attributes:
        single: Space of one environment's observation.
        batched: Space of the whole batch's.
    """

    def __init__(self, obs_mode: str, description: TaskDescription, outputs: dict[str, np.ndarray]):
        self.obs_mode = obs_mode
        self._fields = description["state_fields"]
        tasks = _tasks_of(description)
        self._segments = max(len(task["segmentation_names"]) for task in tasks)
        # Keys of images and what comes with them, and the outputs that they show.
        self.parts: dict[str, str] = {}
        kinds = obs_mode.split("+")
        if kinds[0] == "rgb":
            keys = ["rgb", "proprio"]
            if any(task["family"].startswith("Rotate") for task in tasks):  # only they show a cue
                keys.append("task_cue")
            self.parts = {key: ROW if key in _ROWS else key for key in (*keys, *kinds[1:])}
        self.single = self._space(outputs)
        num_envs = len(outputs["reward"])
        self.batched = batch_space(self.single, num_envs)

    def _space(self, outputs: dict[str, np.ndarray]) -> spaces.Space[Any]:
        if self.parts:
            return _dict({key: self._box(key, outputs) for key in self.parts})
        if self.obs_mode == "state_dict":
            parts: dict[str, dict[str, spaces.Space[Any]]] = {"agent": {}, "extra": {}}
            for group, field in self._grouped():
                parts[group][field["name"]] = _unbounded(field["width"])
            return _dict({name: _dict(part) for name, part in parts.items()})
        if self.obs_mode == "objects_dict":
            agent = {f["name"]: _bounded(f, (f["width"],)) for f in self._agent_fields()}
            objects = {
                _field_name(field): _bounded(field, (self.tokens, field["width"]))
                for field in self._token_fields()
            }
            if OBJECT_MASK in outputs:
                objects["mask"] = spaces.Box(0, 1, (self.tokens, 1), np.uint8)
            return _dict({"agent": _dict(agent), "objects": _dict(objects)})
        if self.obs_mode in _ROWS:
            return self._box(self.obs_mode, outputs)
        return _unbounded(0)

    def _box(self, key: str, outputs: dict[str, np.ndarray]) -> spaces.Box:
        """Space of a part of the observation, for one environment."""
        if key == "objects":
            low = [np.full(f["width"], f["low"], np.float32) for f in self._fields]
            high = [np.full(f["width"], f["high"], np.float32) for f in self._fields]
            return spaces.Box(np.concatenate(low), np.concatenate(high), dtype=np.float32)
        array = _rows(outputs[self.parts.get(key, ROW)])
        shape = array.shape[1:]
        if key == "segmentation":
            return ImageBox(shape, dtype=array.dtype, most=self._segments - 1)
        return ImageBox(shape, dtype=array.dtype) if array.ndim == 4 else _unbounded(shape[0])

    @property
    def tokens(self) -> int:
        """Objects in an observation of the objects modes."""
        return sum(field["name"].endswith("_seen") for field in self._fields)

    def _agent_fields(self) -> list[Field]:
        return [f for f in self._fields if not f["name"].startswith(TOKEN)]

    def _token_fields(self) -> list[Field]:
        """Fields of a token, by those of the first one."""
        return [f for f in self._fields if f["name"].startswith(TOKEN + "0_")]

    def _grouped(self) -> list[tuple[str, Field]]:
        """The fields of a state row, each with the part of state_dict that it belongs to."""
        names = [field["name"] for field in self._fields]
        first = names.index(FIRST_EXTRA_FIELD)
        return [("agent" if i < first else "extra", f) for i, f in enumerate(self._fields)]

    def views(self, outputs: dict[str, np.ndarray]) -> Any:
        """The batched observation: views of the outputs, in the shape of the space."""
        if self.parts:
            return {key: _rows(outputs[name]) for key, name in self.parts.items()}
        if self.obs_mode == "state_dict":
            row = outputs[ROW]
            parts: dict[str, dict[str, np.ndarray]] = {"agent": {}, "extra": {}}
            for group, field in self._grouped():
                begin = field["offset"]
                parts[group][field["name"]] = row[:, begin : begin + field["width"]]
            return parts
        if self.obs_mode == "objects_dict":
            parts = self._objects(outputs[ROW])
            if OBJECT_MASK in outputs:
                parts["objects"]["mask"] = outputs[OBJECT_MASK][:, :, np.newaxis].view(np.uint8)
            return parts
        if self.obs_mode in _ROWS:
            return outputs[ROW]
        return np.zeros((len(outputs["reward"]), 0), np.float32)

    def _objects(self, row: np.ndarray) -> dict[str, dict[str, np.ndarray]]:
        agent = {
            f["name"]: row[:, f["offset"] : f["offset"] + f["width"]] for f in self._agent_fields()
        }
        fields = self._token_fields()
        first, width = fields[0]["offset"], sum(field["width"] for field in fields)
        tokens = row[:, first:].reshape(len(row), self.tokens, width)  # a view, as all parts are
        objects = {}
        for field in fields:
            begin = field["offset"] - first
            objects[_field_name(field)] = tokens[:, :, begin : begin + field["width"]]
        return {"agent": agent, "objects": objects}

    @property
    def keys(self) -> tuple[str, ...]:
        """Outputs that observations are made of."""
        if self.parts:
            return tuple(self.parts.values())
        return () if self.obs_mode == "none" else (ROW,)


def _tasks_of(description: Any) -> list[Any]:
    """The description of each task."""
    return list(description.get("tasks", [description]))


def action_spaces(low: Sequence[float], high: Sequence[float], num_envs: int) -> tuple[Any, Any]:
    """Single and batched action space."""
    single = spaces.Box(np.array(low, np.float32), np.array(high, np.float32), dtype=np.float32)
    return single, batch_space(single, num_envs)


def take(value: Any, index: int) -> Any:
    """A copy of one environment's part of nested dicts of arrays."""
    if isinstance(value, dict):
        return {key: take(part, index) for key, part in value.items()}
    return value[index].copy()


def _rows(array: np.ndarray) -> np.ndarray:
    return array[:, np.newaxis] if array.ndim == 1 else array


def _dict(parts: Mapping[str, spaces.Space[Any]]) -> spaces.Dict:
    return spaces.Dict(OrderedDict(parts))  # an OrderedDict keeps its order


def _unbounded(width: int) -> spaces.Box:
    return spaces.Box(-np.inf, np.inf, (width,), np.float32)


def _bounded(field: Field, shape: tuple[int, ...]) -> spaces.Box:
    return spaces.Box(field["low"], field["high"], shape, np.float32)


def _field_name(field: Field) -> str:
    """Name of a field of the first token without its prefix: position, color, ..."""
    return field["name"].removeprefix(TOKEN + "0_")
