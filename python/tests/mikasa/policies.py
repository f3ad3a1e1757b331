"""A policy that depends on all that it may see, in the original's form and in engram's."""

from __future__ import annotations

from typing import Any

import numpy as np


class Looking:
    """Moves as a function of images and joints.

    Args:
        chunk_size: Actions per answer.
    """

    def __init__(self, chunk_size: int) -> None:
        self.chunk_size = chunk_size

    def forward(self, obs: Any) -> np.ndarray:
        """(1, chunk_size, 7)."""
        return self.answer(*(np.asarray(obs[key]) for key in ("rgb", "proprio")))[:1]

    def answer(self, rgb: np.ndarray, proprio: np.ndarray) -> np.ndarray:
        """(N, chunk_size, 7) of N observations."""
        angle = rgb[:, ::16, ::16].astype(np.float64).mean((1, 2, 3)) + proprio.sum(1)
        actions = np.zeros((len(rgb), self.chunk_size, 7), np.float32)
        for i in range(self.chunk_size):
            actions[:, i, 0] = np.cos(angle + i) / 2
            actions[:, i, 1] = np.sin(angle + i) / 2
            actions[:, i, 2] = -0.3
        return actions


def as_engram(policy: Looking) -> Any:
    """The same for engram.evaluate."""
    return lambda observation: policy.answer(observation["rgb"], observation["proprio"])
