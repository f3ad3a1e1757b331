"""Shared helpers of the tests of engram.mikasa."""

from __future__ import annotations

from contextlib import contextmanager
from typing import Any

import gymnasium as gym
import torch

import engram.mikasa


@contextmanager
def made(id: str, **keywords: Any):
    """gym.make, closed afterwards; one thread unless more are asked for."""
    keywords.setdefault("control_mode", "pd_ee_delta_pose")
    env = gym.make(id, threads=1, **keywords)
    try:
        yield env
    finally:
        env.close()


def shapes(value: Any) -> Any:
    """Nested dicts of tensors as nested dicts of "type shape"."""
    if isinstance(value, dict):
        return {key: shapes(part) for key, part in value.items()}
    if isinstance(value, torch.Tensor):
        return f"{str(value.dtype).removeprefix('torch.')} {tuple(value.shape)}"
    return value


def as_arrays(value: Any) -> Any:
    """Nested dicts of tensors as nested dicts of arrays."""
    if isinstance(value, dict):
        return {key: as_arrays(part) for key, part in value.items()}
    return value.numpy()


def tasks() -> dict[str, str]:
    """Families by id, of the ids that the original registers."""
    return {
        task["id"]: task["family"]
        for task in engram.list()
        if task["id"] in engram.mikasa.registration.REGISTERED and task["id"].endswith("-VLA-v0")
    }
