"""Reads what `engram collect` wrote: one .npz file per episode, and metadata.json."""

from __future__ import annotations

import dataclasses
import json
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np


class DatasetError(Exception):
    """A data set is missing, incomplete or damaged; the message says which and why."""


@dataclasses.dataclass(frozen=True)
class Episode:
    """One demonstration of T steps, from the first observation to the first success."""

    rgb: np.ndarray  # (T, H, W, 6) uint8: base camera, wrist camera; before the action
    proprio: np.ndarray  # (T, 7) float32; before the action
    action: np.ndarray  # (T, 7) float32 in [-1, 1]
    reward: np.ndarray  # (T,) float32; after the action
    success: np.ndarray  # (T,) int32; after the action
    done: np.ndarray  # (T,) int32; after the action
    language_instruction: str
    success_once: bool
    episode_length: int
    episode_seed: int

    def __len__(self) -> int:
        return self.episode_length

    @property
    def image(self) -> np.ndarray:
        """The base camera, (T, H, W, 3)."""
        return self.rgb[..., :3]

    @property
    def wrist_image(self) -> np.ndarray:
        """The wrist camera, (T, H, W, 3)."""
        return self.rgb[..., 3:]

    @classmethod
    def load(cls, path: Path | str) -> Episode:
        """Reads one file; raises DatasetError if it is damaged."""
        try:
            with np.load(path, allow_pickle=False) as file:
                values = {name: file[name] for name in _DTYPES}
        except (OSError, ValueError, KeyError, zipfile.BadZipFile, zlib.error, EOFError) as error:
            raise DatasetError(
                f"'{path}' is not an episode of engram, or damaged: {error}"
            ) from error
        steps = int(values["episode_length"])
        for name, dtype in _DTYPES.items():
            value = values[name]
            if dtype is not None and value.dtype != dtype:
                raise DatasetError(f"'{path}': {name} has dtype {value.dtype}, {dtype} expected")
            if name in _PER_STEP and value.shape[:1] != (steps,):
                raise DatasetError(
                    f"'{path}': {name} has shape {value.shape}, {steps} steps expected"
                )
        for name in ("language_instruction", "success_once", "episode_length", "episode_seed"):
            values[name] = values[name].item()
        return cls(**values)


_DTYPES = {
    "rgb": np.dtype(np.uint8),
    "proprio": np.dtype(np.float32),
    "action": np.dtype(np.float32),
    "reward": np.dtype(np.float32),
    "success": np.dtype(np.int32),
    "done": np.dtype(np.int32),
    "language_instruction": None,
    "success_once": np.dtype(np.bool_),
    "episode_length": np.dtype(np.int32),
    "episode_seed": np.dtype(np.int64),
}
_PER_STEP = ("rgb", "proprio", "action", "reward", "success", "done")


class DemonstrationFolder(Sequence):
    """The episodes of one task, in order; each is read when it is asked for."""

    def __init__(self, path: Path | str):
        self.path = Path(path)
        self.metadata_path = self.path / "metadata.json"
        try:
            self.metadata: dict[str, Any] = json.loads(self.metadata_path.read_text())
            self.env_id: str = self.metadata["env_id"]
            count = self.metadata["num_episodes"]
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise DatasetError(f"'{self.metadata_path}' cannot be read: {error}") from error
        self.files = [self.path / f"train_data_{i}.npz" for i in range(count)]
        missing = [file for file in self.files if not file.is_file()]
        if missing:
            raise DatasetError(
                f"'{missing[0]}' is missing; metadata.json tells of {count} episodes"
            )
        if not self.files:
            raise DatasetError(f"'{self.path}' holds no episodes")

    def __len__(self) -> int:
        return len(self.files)

    def __getitem__(self, index):
        if isinstance(index, slice):
            return [Episode.load(file) for file in self.files[index]]
        return Episode.load(self.files[index])

    def __iter__(self) -> Iterator[Episode]:
        return map(Episode.load, self.files)


def find_folders(root: Path | str, ids: Sequence[str] = ()) -> list[DemonstrationFolder]:
    """The data sets in <root>/data_npz, those of `ids` only where any are given."""
    parent = Path(root) / "data_npz"
    if not parent.is_dir():
        raise DatasetError(
            f"'{root}' has no folder data_npz; `engram collect ID --out {root}` makes it"
        )
    present = sorted(path.name for path in parent.iterdir() if path.is_dir())
    for env_id in ids:
        if env_id not in present:
            raise DatasetError(
                f"no data of {env_id} in '{parent}'; there are: {', '.join(present)}"
            )
    folders = [DemonstrationFolder(parent / env_id) for env_id in (ids or present)]
    if not folders:
        raise DatasetError(f"'{parent}' holds no data sets")
    return folders


def no_progress(done: int, total: int) -> None:
    """What converters call after every episode, where nobody listens."""
