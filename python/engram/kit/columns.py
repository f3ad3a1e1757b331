"""Columns of a batch as a task sees them: NumPy views with one row per environment."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
_WRITTEN = True


class Column(NamedTuple):
    """How the rows of a column look in a task."""

    shape: tuple[int, ...] = ()  # of one row, without the environments
    writable: bool = False
    dtype: Any = None  # seen as that type of the same size

    @property
    def width(self) -> int:
        return math.prod(self.shape)

    def view(self, raw: Array) -> Array:
        """The view of an array of shape (environments, width or more)."""
        rows = raw[:, : self.width]
        if self.dtype is not None:
            rows = rows.view(self.dtype)
        shaped = rows.reshape(raw.shape[0], *self.shape)
        if not self.writable:
            shaped = shaped[...]
            shaped.flags.writeable = False
        return shaped


def engine_columns(
    props: int, action_dim: int, oracle_dim: int, answers: bool, choices: int = 0
) -> dict[str, Column]:
    """The engine's columns that are attributes of a task; ``Task`` documents them."""
    columns = {
        "elapsed": Column(),
        "seed": Column(),
        "episode": Column(),
        "policy_key": Column(),
        "qpos": Column((9,)),
        "qvel": Column((9,)),
        "tcp_pos": Column((3,)),
        "tcp_quat": Column((4,)),
        "action": Column((action_dim,)),
        "previous_action": Column((action_dim,)),
        "prop_pos": Column((props, 3), _WRITTEN),
        "prop_quat": Column((props, 4), _WRITTEN),
        "prop_qvel": Column((props, 6), _WRITTEN),
        "prop_status": Column((props,), _WRITTEN, np.uint8),
        "prop_rgba": Column((props, 4), _WRITTEN),
        "prop_emission": Column((props,), _WRITTEN),
        "covered": Column((), _WRITTEN),
        "finger_force": Column((props, 2, 3)),
        "moved": Column((props,), _WRITTEN, np.uint8),
        "success": Column((), _WRITTEN, np.bool_),
        "failed": Column((), _WRITTEN, np.bool_),
        "freeze_steps": Column((), _WRITTEN),
        "cue_end": Column((), _WRITTEN),
        "actions": Column((7,), _WRITTEN),
    }
    if oracle_dim > 0:
        columns["oracle_info"] = Column((oracle_dim,) if oracle_dim > 1 else (), _WRITTEN)
    if answers:
        columns["answered"] = Column((), _WRITTEN, np.bool_)
        columns["first_answer"] = Column((), _WRITTEN)
        columns["first_answer_correct"] = Column((), _WRITTEN, np.bool_)
    if choices > 0:
        columns["choice"] = Column((choices,))
    return columns


ENGINE_NAMES = frozenset(engine_columns(1, 7, 1, True, 1)) | {"n", "rows"}

# Infos and observations of all tasks, beside those of the engine's columns.
INFO_NAMES = frozenset({
    "depth", "elapsed_steps", "episode_return", "final_info", "final_obs", "final_observation",
    "instruction", "language_instruction", "object_mask", "objects", "observation", "proprio",
    "reward", "reward_dict", "rgb", "segmentation", "success_once", "task", "task_cue",
    "task_index", "terminated", "truncated", "unstable",
})  # fmt: skip


class Rows:
    """The views of one set of rows, all of a batch or spare ones, by the names of attributes."""

    def __init__(self, raw: Mapping[str, Array], columns: Mapping[str, tuple[str, Column]]) -> None:
        self.count = len(raw["elapsed"])
        self.views = {
            attribute: column.view(raw[name]) for attribute, (name, column) in columns.items()
        }
        self._numbers = np.arange(self.count)
        self._numbers.flags.writeable = False

    def first(self, count: int) -> dict[str, Any]:
        """The views of the first rows, and their number as "n"."""
        rows = {name: view[:count] for name, view in self.views.items()}
        return {**rows, "n": count, "rows": self._numbers[:count]}
