"""Readers of episodes in every format."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from engram.datasets import additions, checks, source
from engram.datasets.checks import DatasetError, reading
from engram.datasets.episodes import RLDS_FOLDER, DemonstrationFolder, Metadata
from engram.datasets.spaces import Spaces
from engram.datasets.stored import StoredEpisode, images, maps


def _from_npz(folder: DemonstrationFolder, _: Path) -> Iterator[StoredEpisode]:
    for episode in folder:
        yield StoredEpisode(
            folder.spaces,
            episode.episode_seed,
            episode.action,
            episode.proprio,
            episode.language_instruction,
            episode.rgb,
            episode.reward,
            episode.success,
            episode.depth,
            episode.segmentation,
            episode.state,
            episode.objects,
        )


def _floats(values: list[float], *shape: int) -> np.ndarray:
    return np.array(values, np.float32).reshape(shape)


def _from_rlds(folder: Metadata, root: Path) -> Iterator[StoredEpisode]:
    from engram.datasets import rlds, tf_example

    path = root / RLDS_FOLDER / folder.env_id / rlds.VERSION
    source.verify(path)
    shards = sorted(path.glob(f"{rlds.NAME}-{rlds.SPLIT}.tfrecord-*"))
    if not shards:
        raise DatasetError(f"'{path}' holds no records")
    for shard in shards:
        with reading(shard), open(checks.regular_file(shard), "rb") as file:
            for record in tf_example.read_records(file):
                yield _rlds_episode(tf_example.parse_example(record), folder.spaces)


def _rlds_episode(fields: dict[str, list], spaces: Spaces) -> StoredEpisode:
    cameras = [fields[f"steps/observation/{name}"] for name in ("image", "wrist_image")]
    action = _floats(fields["steps/action"], -1, len(spaces.action_names))
    if any(len(files) != len(action) for files in cameras):
        raise DatasetError(f"images of {[len(c) for c in cameras]} and {len(action)} steps")
    checks.whole_number("steps", len(action), 1, checks.MAX_STEPS)
    found: dict[str, Any] = {
        name: np.stack(
            [maps(fields[f"steps/observation/{key}"]) for key in additions.map_keys(name)], axis=-1
        )
        for name in additions.MAPS
        if f"steps/observation/{name}" in fields
    }
    for name in additions.ROWS:
        if f"steps/observation/{name}" in fields:
            found[name] = _floats(fields[f"steps/observation/{name}"], len(action), -1)
    return StoredEpisode(
        spaces,
        fields["episode_metadata/episode_seed"][0],
        action,
        _floats(fields["steps/observation/proprio"], -1, len(spaces.proprio_names)),
        fields["steps/language_instruction"][0].decode(),
        np.concatenate([images(files) for files in cameras], axis=-1),
        _floats(fields["steps/reward"], -1),
        **found,
    )


def _from_lerobot(folder: DemonstrationFolder, root: Path) -> Iterator[StoredEpisode]:
    from engram.datasets.lerobot import reader

    return reader.read(folder, root)


def _from_hdf5(folder: Metadata, root: Path) -> Iterator[StoredEpisode]:
    from engram.datasets import hdf5_reader

    return hdf5_reader.read(folder, root)


READERS: dict[str, Callable[[Any, Path], Iterator[StoredEpisode]]] = {
    "npz": _from_npz,
    "rlds": _from_rlds,
    "lerobot": _from_lerobot,
    "hdf5": _from_hdf5,
}
