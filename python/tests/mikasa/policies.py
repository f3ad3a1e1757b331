"""Policies that depend on what they see, in the original's form and in engram's."""

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


class Reaching:
    """Moves to where its own joints say that the robot's front is, one action an answer."""

    chunk_size = 1

    def forward(self, obs: Any) -> np.ndarray:
        """(7,)."""
        return self.answer(np.asarray(obs["rgb"]), np.asarray(obs["proprio"]))[0, 0]

    def answer(self, rgb: np.ndarray, proprio: np.ndarray) -> np.ndarray:
        """(N, 1, 7) of N observations."""
        actions = np.zeros((len(proprio), 1, 7), np.float32)
        actions[:, 0, :3] = np.clip(4 * (np.array([0, 0.1, 0.05]) - proprio[:, :3]), -1, 1)
        actions[:, 0, 6] = np.sign(proprio[:, 6] - 0.04)
        return actions


def as_engram(policy: Any) -> Any:
    """A policy for engram.evaluate."""
    return lambda observation: policy.answer(observation["rgb"], observation["proprio"])
