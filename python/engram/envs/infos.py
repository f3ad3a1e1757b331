"""Infos in Gymnasium's forms: masked columns of a batch, and rows of single environments."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from typing import Any

import numpy as np

from engram import _core
from engram.envs.compat import GYMNASIUM_1
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
        without: Collection[str],
        same_step: bool,
        exported: Callable[[Any], Callable[[], Any]],
        language: bool,
        group: TaskGroup,
    ) -> None:
        self._batch = batch
        self._language = language
        self._tasks = group.names
        self._known = group.known()
        left_out = {*_RETURNED, *layout.keys, *without}
        names = [name for name in outputs if name not in left_out]
        self.views = {name: _read_only(outputs[name]) for name in names}
        self._columns = _columns(self.views, exported)
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

    def refresh_instructions(self, indices: Iterable[int]) -> None:
        """Updates the instructions of environments that have begun an episode, if needed."""
        if not self._language:
            return
        fresh = self._instructions.copy()
        for i in indices:
            fresh[i] = self._batch.instruction(int(i))
        self._instructions = fresh

    def columns(self, which: np.ndarray) -> dict[str, Any]:
        """The whole batch's: every name beside a mask of the environments that it holds for."""
        return self._masked(self._columns, self._instructions, which)

    def row(self, index: int) -> dict[str, Any]:
        """One environment's: scalars and copies."""
        return self._row(self.views, self._instructions, index)

    def finals(self) -> dict[str, Any] | None:
        """Last observations and infos of the episodes that have just ended (same-step mode).

        None if there are none. Instructions are those of the new episodes afterwards.
        """
        ended = np.flatnonzero(self._final_mask)
        if not ended.size:
            return None
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
        if self._language:
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
        if self._language:
            info["language_instruction"] = instructions[index]
        return info


def _columns(
    views: dict[str, np.ndarray], exported: Callable[[Any], Callable[[], Any]]
) -> list[_Column]:
    return [(name, f"_{name}", view, exported(view)) for name, view in views.items()]


def _read_only(array: np.ndarray) -> np.ndarray:
    """The same memory; what is written into infos would stay there."""
    view = array.view()
    view.flags.writeable = False
    return view


def _is_known(view: np.ndarray) -> np.ndarray:
    return ~np.isnan(view).reshape(len(view), -1).all(axis=1)


def _scalar(value: Any) -> Any:
    return bool(value) if isinstance(value, np.bool_) else value
