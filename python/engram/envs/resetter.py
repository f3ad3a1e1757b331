"""Resets of a batch: which environments begin new episodes, and from which seeds."""

from __future__ import annotations

from typing import Any

import numpy as np

from engram import _core
from engram._args import methods
from engram.envs.groups import TaskGroup


class Resetter:
    """Resets environments of a batch.

    Attributes:
        started: True once there are episodes, by a reset or a restored snapshot.
    """

    def __init__(
        self, batch: _core.Batch, group: TaskGroup, seed: int, all_envs: np.ndarray
    ) -> None:
        """seed: of the batch; all_envs: (N,) True."""
        self._batch = batch
        self._group = group
        self._seed = seed
        self._all = all_envs
        self.started = False

    def reset(self, seed: Any, options: Any) -> np.ndarray:
        """Resets by the arguments of ``VectorEnv.reset``; returns the mask of what was reset."""
        count = len(self._all)
        seeds = methods.seed_list(seed, count, self._group.slots)
        parts = [methods.reset_options(part, count) for part in self._group.split_reset(options)]
        saved = self._batch.save(-1) if self.started and len(parts) > 1 else None
        try:
            for part in parts:
                self._reset_part(seeds, *part)
        except Exception:
            if saved is not None:  # a bad call changes nothing
                self._batch.restore(-1, saved)
            raise
        self.started = True
        masks = [self._all if mask is None else mask for mask, *_ in parts]
        which: np.ndarray = np.logical_or.reduce(masks) if len(masks) > 1 else masks[0]
        return which

    def _reset_part(self, seeds: Any, mask: Any, pins: Any, constants: Any) -> None:
        """Resets with checked arguments; some of the seeds may be None."""
        if not isinstance(seeds, list):
            self._batch.reset(mask, seeds, pins, constants)
            return
        given = np.array([value is not None for value in seeds])
        filled = [
            self._seed + slot if value is None else value
            for slot, value in zip(self._group.slots.tolist(), seeds)
        ]
        array = np.array([value % 2**64 for value in filled], np.uint64)
        if not self.started:
            self._batch.reset(mask, array, pins, constants)
            return
        chosen = self._all if mask is None else mask
        for part, part_seeds in ((chosen & given, array), (chosen & ~given, None)):
            if part.any():
                self._batch.reset(part, part_seeds, pins, constants)
