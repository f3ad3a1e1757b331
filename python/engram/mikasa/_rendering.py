"""Rendering for people, tiled as in the original."""

from __future__ import annotations

from typing import Any

import numpy as np

from engram.envs.vector_env import VectorEnv
from engram.mikasa._keywords import Settings
from engram.mikasa._torch import torch

_WITHOUT_HUMAN = ("sensors", "cameras")


def images(batch: VectorEnv[Any], mode: str, chosen: Settings) -> torch.Tensor:
    """One image per environment, uint8 (B, height, width, 3)."""
    tiles = []
    for i in range(batch.num_envs):
        human = batch.frame(i) if mode not in _WITHOUT_HUMAN else None
        sensors = [] if mode == "rgb_array" else _sensors(batch, i, chosen)
        if human is None:
            tiles.append(np.concatenate(sensors, axis=1))
        else:
            tiles.append(_beside(human, sensors))
    return torch.from_numpy(np.stack(tiles))


def _sensors(batch: VectorEnv[Any], index: int, chosen: Settings) -> list[np.ndarray]:
    cameras: Any = chosen.cameras
    return [batch.frame(index, camera, chosen.image_size) for camera in cameras]


def _beside(human: np.ndarray, sensors: list[np.ndarray]) -> np.ndarray:
    """The large image, to its right a column of the small ones, from the top."""
    if not sensors:
        return human
    column = np.concatenate(sensors, axis=0)
    height = max(len(human), len(column))
    result = np.zeros((height, human.shape[1] + column.shape[1], 3), np.uint8)
    result[: len(human), : human.shape[1]] = human
    result[: len(column), human.shape[1] :] = column
    return result
