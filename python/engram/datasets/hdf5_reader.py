"""Reads the episodes of an HDF5 file that was written here."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from engram.datasets import additions, checks, source
from engram.datasets.checks import DatasetError, reading
from engram.datasets.episodes import HDF5_FILE, HDF5_FOLDER, Metadata
from engram.datasets.spaces import Spaces
from engram.datasets.stored import StoredEpisode

_FILTERS = {h5py.h5z.FILTER_DEFLATE}  # gzip alone; for others plugins may be loaded


def read(folder: Metadata, root: Path) -> Iterator[StoredEpisode]:
    """The episodes of <root>/data_hdf5/<id>, in order."""
    path = root / HDF5_FOLDER / folder.env_id / HDF5_FILE
    source.verify(path.parent)
    with reading(path), h5py.File(checks.regular_file(path), "r") as file:
        for number in range(len(folder)):
            group = _child(file, f"data/demo_{number}", h5py.Group)
            yield _episode(group, folder.spaces)


def _episode(group: h5py.Group, spaces: Spaces) -> StoredEpisode:
    steps = checks.whole_number("num_samples", int(group.attrs["num_samples"]), 1, checks.MAX_STEPS)

    observations = _child(group, "obs", h5py.Group)

    def array(name: str, kind: type, *row: int) -> np.ndarray:
        return _array(group, name, kind, (steps, *row))

    def cameras(keys: tuple[str, ...], kind: type, shape: tuple[int, ...]) -> np.ndarray:
        return np.concatenate([array(f"obs/{key}", kind, *shape) for key in keys], axis=-1)

    found: dict[str, Any] = {
        name: cameras(additions.map_keys(name), additions.MAP_TYPE, additions.MAP_SHAPE)
        for name in additions.MAPS
        if name in observations
    }
    for name in additions.ROWS:
        if name in observations:
            rows = _child(group, f"obs/{name}", h5py.Dataset)
            found[name] = array(f"obs/{name}", np.float32, *rows.shape[1:2])
    return StoredEpisode(
        spaces,
        int(group.attrs["episode_seed"]),
        array("actions", np.float32, len(spaces.action_names)),
        array("obs/proprio", np.float32, len(spaces.proprio_names)),
        group.attrs["language_instruction"],
        cameras(("image", "wrist_image"), np.uint8, checks.CAMERA_SHAPE),
        array("rewards", np.float32),
        **found,
    )


def _array(group: h5py.Group, name: str, kind: type, shape: tuple[int, ...]) -> np.ndarray:
    found = _child(group, name, h5py.Dataset)
    if found.dtype != kind or found.shape != shape:
        raise DatasetError(
            f"{name} is {found.dtype} of shape {found.shape}, {np.dtype(kind)} of shape {shape} "
            "expected"
        )
    if found.external or found.is_virtual or not _filters(found) <= _FILTERS:
        raise DatasetError(f"{name} is not in the file itself, or neither plain nor gzip")
    # A chunk is unpacked as a whole, however little of it the array needs.
    if found.chunks and any(chunk > size for chunk, size in zip(found.chunks, shape)):
        raise DatasetError(f"{name} has chunks of {found.chunks}, at most {shape} expected")
    values: np.ndarray = found[()]
    return values


def _filters(found: h5py.Dataset) -> set[int]:
    """Codes of all filters that its chunks go through."""
    made = found.id.get_create_plist()
    return {made.get_filter(number)[0] for number in range(made.get_nfilters())}


def _child(parent: h5py.Group, path: str, kind: type) -> h5py.Group | h5py.Dataset:
    """What is there by hard links, which lead nowhere outside of the file."""
    for name in path.split("/"):
        if not isinstance(parent, h5py.Group) or not isinstance(
            parent.get(name, getlink=True), h5py.HardLink
        ):
            raise DatasetError(f"{path} is missing, or a link")
        parent = parent[name]
    if not isinstance(parent, kind):
        raise DatasetError(f"{path} is no {kind.__name__.lower()}")
    return parent
