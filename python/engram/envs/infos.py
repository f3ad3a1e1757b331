"""Infos in Gymnasium's forms: masked columns of a batch, and rows of single environments."""

from __future__ import annotations

import functools
from collections.abc import Callable, Collection, Sequence
from typing import Any

import numpy as np

from engram import _core
from engram.envs.compat import GYMNASIUM_1
from engram.envs.copies import same
from engram.envs.groups import CONSTANT, TaskGroup
from engram.envs.spaces import Layout, take

# Outputs that ``reset`` and ``step`` return themselves.
_RETURNED = ("observation", "rgb", "reward", "terminated", "truncated", "final_mask")
# Infos that are NaN until there are any; until then their mask is False.
_SOMETIMES = frozenset(["reward_dict"])

# A name, the name of its mask, the view of its values, and a function that returns them.
_Column = tuple[str, str, np.ndarray, Callable[[], Any]]


class Infos:
    """The infos of a batch: its outputs beside observations, rewards and endings.

    Attributes:
        language: Whether they have instructions.
        views: Columns by name, views of engram's own buffers.
        final_views: Columns of episodes that have just ended; empty unless batches reset in the
            same step.
    """

    def __init__(
        self,
        batch: _core.Batch,
        outputs: dict[str, np.ndarray],
        layout: Layout,
        *,
        all_envs: np.ndarray,
        without: Collection[str],
        same_step: bool,
        exported: Callable[[Any], Callable[[], Any]],
        language: bool,
        group: TaskGroup,
    ) -> None:
        self._batch = batch
        self.language = language
        self._tasks = group.names
        self._known = group.known()
        left_out = {*_RETURNED, *layout.keys, *without}
        names = [name for name in outputs if name not in left_out]
        self.views = {name: _read_only(outputs[name]) for name in names}
        self._columns = _columns(self.views, exported)
        self._all_envs = all_envs
        # Infos of a step in which nothing is missing, and what is to be copied into them.
        self._usual: dict[str, Any] = {}
        for name, mask, view, _ in self._columns:
            self._usual.update({name: view, mask: self._known.get(name, all_envs)})
        if self._tasks is not None:
            self._usual.update({"task": self._tasks, "_task": all_envs})
        self._copied = (
            [] if exported is same else [(name, get) for name, _, _, get in self._columns]
        )
        self._sometimes = language or not _SOMETIMES.isdisjoint(names)
        # Infos hold the array, so that new instructions go into a new one.
        self._instructions = np.full(batch.num_envs, "", dtype=object)
        self.final_views: dict[str, np.ndarray] = {}
        if same_step:
            # What never changes, such as the number of the task, has no last value.
            finals: dict[str, Any] = {
                name: outputs[name] if name in CONSTANT else batch.final_output(name)
                for name in (*names, *layout.keys)
            }
            self._final_mask = outputs["final_mask"]
            self._final_observation = layout.views({**outputs, **finals})
            self.final_views = {name: _read_only(finals[name]) for name in names}
            self._final_columns = _columns(self.final_views, exported)

    def refresh_instructions(self, indices: Sequence[int] | np.ndarray) -> None:
        """Updates the instructions of environments that have begun an episode, if needed."""
        if not self.language or not len(indices):
            return
        fresh = self._instructions.copy()
        for i in indices:
            fresh[i] = self._batch.instruction(int(i))
        self._instructions = fresh

    def columns(self, which: np.ndarray) -> dict[str, Any]:
        """The whole batch's: every name beside a mask of the environments that it holds for."""
        if which is self._all_envs and not self._sometimes:
            info = self._usual.copy()
            for name, copied in self._copied:
                info[name] = copied()
            return info
        return self._masked(self._columns, self._instructions, which)

    def row(self, index: int) -> dict[str, Any]:
        """One environment's: scalars and copies."""
        return self._row(self.views, self._instructions, index)

    def row_reader(self, index: int) -> Callable[[], dict[str, Any]]:
        """Makes a function that returns ``row(index)``, for one who reads it in every step."""
        if self._sometimes:
            return functools.partial(self.row, index)
        parts = [(name, _reader(view, index)) for name, view in self.views.items()]
        return lambda: {name: read() for name, read in parts}

    def finals(self) -> dict[str, Any] | None:
        """Last observations and infos of the episodes that have just ended (same-step mode).

        None if there are none. Instructions are those of the new episodes afterwards.
        """
        if not np.count_nonzero(self._final_mask):
            return None
        ended = np.flatnonzero(self._final_mask)
        which = self._final_mask.copy()
        instructions = self._instructions
        self.refresh_instructions(ended)
        observations = np.full(len(which), None, dtype=object)
        for i in ended:
            observations[i] = take(self._final_observation, int(i))
        if GYMNASIUM_1:
            infos: Any = self._masked(self._final_columns, instructions, which)
        else:
            infos = np.full(len(which), None, dtype=object)
            for i in ended:
                infos[i] = self._row(self.final_views, instructions, int(i))
        result = {"final_obs": observations, "final_info": infos}
        if not GYMNASIUM_1:
            result["final_observation"] = observations
        return {**result, **{f"_{name}": which for name in result}}

    def _masked(
        self, columns: list[_Column], instructions: np.ndarray, which: np.ndarray
    ) -> dict[str, Any]:
        info: dict[str, Any] = {}
        for name, mask, view, export in columns:
            info[name] = export()
            holds = which & self._known[name] if name in self._known else which
            info[mask] = holds & _is_known(view) if name in _SOMETIMES else holds
        if self._tasks is not None:
            info["task"], info["_task"] = self._tasks, which
        if self.language:
            info["language_instruction"] = _read_only(instructions)
            info["_language_instruction"] = which
        return info

    def _row(
        self, views: dict[str, np.ndarray], instructions: np.ndarray, index: int
    ) -> dict[str, Any]:
        info: dict[str, Any] = {
            name: view[index].copy() if view.ndim > 1 else _scalar(view[index])
            for name, view in views.items()
            if (name not in _SOMETIMES or _is_known(view)[index])
            and (name not in self._known or self._known[name][index])
        }
        if self._tasks is not None:
            info["task"] = self._tasks[index]
        if self.language:
            info["language_instruction"] = instructions[index]
        return info


def _columns(
    views: dict[str, np.ndarray], exported: Callable[[Any], Callable[[], Any]]
) -> list[_Column]:
    return [(name, f"_{name}", view, exported(view)) for name, view in views.items()]


def _read_only(array: np.ndarray) -> np.ndarray:
    """Views of the memory; what is written into infos would stay there."""
    view = array.view()
    view.flags.writeable = False
    return view


def _is_known(view: np.ndarray) -> np.ndarray:
    return ~np.isnan(view).reshape(len(view), -1).all(axis=1)


def _reader(view: np.ndarray, index: int) -> Callable[[], Any]:
    """Makes a function that returns one environment's value."""
    if view.ndim > 1:
        copy: Callable[[], Any] = view[index].copy
        return copy
    # The item of a bool array is a bool.
    return functools.partial(view.item if view.dtype == np.bool_ else view.__getitem__, index)


def _scalar(value: Any) -> Any:
    return bool(value) if isinstance(value, np.bool_) else value
