"""Saves played episodes as demonstrations, in the format of `engram collect` (docs/datasets.md)."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import engram
from engram.datasets import Episode
from engram.datasets.demonstration_writer import append_episode

_PLAYER = "engram play"
_STEPS = ("rgb", "proprio", "action", "reward", "success", "done")


class SaveError(Exception):
    """An episode cannot be saved; the message gives the reason."""


def save(
    out: Path, id: str, seed: int, actions: Sequence[npt.NDArray[np.float32]]
) -> tuple[Path, int]:
    """Replays the actions and writes the episode; returns the file and the folder's episode count.

    Raises:
        SaveError: The episode is no demonstration.
        DatasetError: The folder holds other files.
    """
    episode = _replay(id, seed, actions)
    return append_episode(out, id, episode, player=_PLAYER, version=engram.__version__)


def _replay(id: str, seed: int, actions: Sequence[npt.NDArray[np.float32]]) -> Episode:
    """The episode as played, in an environment as `python -m engram.datasets replay` makes it."""
    rows: dict[str, list[Any]] = {name: [] for name in _STEPS}
    with contextlib.closing(
        engram.make(id, obs_mode="rgb", control_mode="pd_ee_delta_pose")
    ) as env:
        observation, _ = env.reset(seed=seed)
        instruction = env.language_instruction
        for action in actions:
            rows["rgb"].append(observation["rgb"])
            rows["proprio"].append(observation["proprio"])
            rows["action"].append(action)
            observation, reward, terminated, truncated, info = env.step(action)
            success = bool(info["success"])
            rows["reward"].append(np.float32(reward))
            rows["success"].append(success)
            rows["done"].append(success or terminated or truncated)
    successes = rows["success"]
    if not successes or not successes[-1] or any(successes[:-1]):
        raise SaveError("the episode did not succeed; demonstrations do")
    columns: dict[str, Any] = {name: np.array(rows[name]) for name in _STEPS}
    return Episode(
        **columns,
        language_instruction=instruction,
        success_once=True,
        episode_length=len(actions),
        episode_seed=seed,
    )
