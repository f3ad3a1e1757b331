"""A sound data set with depth and segmentation, written by hand."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from sound_dataset import EPISODES, ID, STEPS, arrays_of, metadata_text, sound_metadata

MAPS = ("depth", "segmentation")
NAMES = ["background", "table", "cube_blue"]


def maps_of(number: int) -> dict[str, np.ndarray]:
    """The arrays of depth and segmentation of a sound episode."""
    rng = np.random.default_rng(number)
    shape = (STEPS, 128, 128, 2)
    return {
        "depth": rng.integers(0, 32768, shape, np.uint16),
        "segmentation": rng.integers(0, len(NAMES), shape, np.uint16),
        "segmentation_names": np.array(NAMES),
    }


def write_mapped(root: Path, listed: tuple[str, ...] = MAPS, **changes: np.ndarray) -> Path:
    """Writes the set below root; changes: other arrays in its last episode."""
    folder = root / "data_npz" / ID
    folder.mkdir(parents=True, exist_ok=True)
    for number in range(EPISODES):
        arrays = arrays_of(number) | maps_of(number)
        if number == EPISODES - 1:
            arrays |= changes
        np.savez_compressed(folder / f"train_data_{number}.npz", **arrays)
    document: dict[str, Any] = sound_metadata()
    document["engram"] |= dict.fromkeys(listed, True)
    (folder / "metadata.json").write_text(metadata_text(document))
    return folder
