"""Writes demonstrations as RLDS: TFRecord files that tensorflow_datasets reads.

One episode is one record: a tf.train.Example in which every field of `steps` is a list over the
steps. Images are PNG, so that nothing is lost.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from engram.datasets import additions, card, checks, source, tf_example
from engram.datasets.collected import CollectedEpisodes, EpisodeSource
from engram.datasets.episodes import (
    RLDS_FOLDER,
    RLDS_VERSION,
    Episode,
    no_progress,
)
from engram.datasets.folders import new_folder
from engram.datasets.rlds_features import features, label_values
from engram.datasets.work import in_order, pngs

NAME = "mikasa_dataset"
VERSION = RLDS_VERSION
SPLIT = "train"
SHARD_BYTES = 256 << 20  # after which the next shard begins


def convert(
    folder: EpisodeSource,
    root: Path | str,
    jobs: int = 0,
    progress: Callable[[int, int], None] = no_progress,
    *,
    labels: bool = False,
    depth: bool = False,
    segmentation: bool = False,
) -> Path:
    """Writes <root>/data_rlds/<id>/1.0.0 and returns its path.

    The folder appears when it is complete; one that was written here before is replaced. jobs:
    threads that encode, 0 for one per core; progress is called with the episodes done and all of
    them; labels: adds those of the demonstrations, which are privileged; depth, segmentation: add
    these pictures. Raises DatasetError, and leaves everything as it was, if an episode is damaged.
    """
    checks.whole_number("jobs", jobs, 0, checks.MAX_JOBS)
    added = additions.chosen(labels=labels, depth=depth, segmentation=segmentation)
    folder.require(added)
    place = (RLDS_FOLDER, folder.env_id, VERSION)
    instructions: set[str] = set()
    segments = additions.SegmentNames()
    with new_folder(root, *place) as path:
        with (
            _Shards(path) as shards,
            in_order(
                lambda load: _record(load(), folder.env_id, added), folder.loaders(), jobs
            ) as records,
        ):
            for done, (record, episode) in enumerate(records, 1):
                shards.add(record)
                instructions.add(episode.language_instruction)
                if additions.SEGMENTATION in added:
                    segments.add(episode.segmentation_names)
                progress(done, len(folder))
        described = features(folder.spaces, added, episode.labels if labels else None)
        source.write_json(path / "features.json", described)
        source.write_json(path / "dataset_info.json", _dataset_info(shards.lengths, shards.bytes))
        source.write_json(path / source.NAME, source.with_additions(folder, added))
        (path / "metadata.json").write_bytes(folder.metadata_bytes)
        (path / "README.md").write_text(_card(folder, sorted(instructions), added))
    return Path(root).joinpath(*place)


class _Shards:
    """Files of records. Their names say how many there are, which is known at the end."""

    def __init__(self, folder: Path):
        self.bytes = 0
        self.lengths: list[int] = []  # in records
        self._folder = folder
        self._file: BinaryIO | None = None

    def __enter__(self) -> _Shards:
        return self

    def __exit__(self, *_: object) -> None:
        if self._file is not None:
            self._file.close()
        for shard in range(len(self.lengths)):
            self._path(shard).rename(self._path(shard, len(self.lengths)))

    def add(self, record: bytes) -> None:
        if self._file is None or self._file.tell() >= SHARD_BYTES:
            if self._file is not None:
                self._file.close()
            self._file = open(self._path(len(self.lengths)), "wb")  # noqa: SIM115 (__exit__)
            self.lengths.append(0)
        tf_example.write_record(self._file, record)
        self.bytes += len(record)
        self.lengths[-1] += 1

    def _path(self, shard: int, shards: int | None = None) -> Path:
        name = f"{NAME}-{SPLIT}.tfrecord-{shard:05d}"
        return self._folder / (name if shards is None else f"{name}-of-{shards:05d}")


def serialize(episode: Episode, env_id: str, added: Collection[str] = ()) -> bytes:
    """One episode as a tf.train.Example, with these additions."""
    steps = len(episode)
    last = [0] * (steps - 1) + [1]
    fields: dict[str, Sequence[Any]] = {
        "steps/observation/image": pngs(episode.image),
        "steps/observation/wrist_image": pngs(episode.wrist_image),
        "steps/observation/proprio": episode.proprio.ravel().tolist(),
        "steps/action": episode.action.ravel().tolist(),
        "steps/reward": episode.reward.tolist(),
        "steps/discount": [1.0] * steps,
        "steps/is_first": [1] + [0] * (steps - 1),
        "steps/is_last": last,
        "steps/is_terminal": last,
        "steps/language_instruction": [episode.language_instruction.encode()] * steps,
        "episode_metadata/env_id": [env_id.encode()],
        "episode_metadata/episode_seed": [episode.episode_seed],
    }
    for name, values in episode.maps(added).items():
        for camera, key in enumerate(additions.map_keys(name)):
            fields[f"steps/observation/{key}"] = pngs(values[..., camera])
    if additions.SEGMENTATION in added and episode.segmentation_names is not None:
        names = [name.encode() for name in episode.segmentation_names]
        fields[f"episode_metadata/{additions.SEGMENT_NAMES}"] = names
    if additions.LABELS in added and episode.labels is not None:
        fields |= label_values(episode.labels, episode.language_instruction)
    return tf_example.serialize_example(fields)


def _record(episode: Episode, env_id: str, added: Collection[str]) -> tuple[bytes, Episode]:
    """The record, and the episode without its pictures, of which many would fill the memory."""
    nothing = np.empty((0, *checks.PICTURE_SHAPE), np.uint8)
    without = dataclasses.replace(episode, rgb=nothing, depth=None, segmentation=None)
    return serialize(episode, env_id, added), without


def is_written(folder: CollectedEpisodes, root: Path | str, **options: bool) -> bool:
    """True if the folder was written from the same collection; refuses another one."""
    return source.is_written(Path(root) / RLDS_FOLDER / folder.env_id / VERSION, folder, **options)


def _card(folder: EpisodeSource, instructions: list[str], added: Collection[str]) -> str:
    spaces = folder.spaces
    notes = [
        f"`steps/observation/proprio`, before the action: {', '.join(spaces.proprio_names)}"
        + (".", "; angles are the benchmark's, from -pi to pi.")[not spaces.joint_proprio],
        f"`steps/action`: {', '.join(spaces.action_names)}.",
    ]
    notes += card.map_notes(added, "`steps/observation/{}`, `wrist_{}`", "`episode_metadata`")
    if additions.LABELS in added:
        notes.append(
            "**Labels are privileged**: `steps/privileged` tells what a policy has to find out. "
            "Train on it as a target, or for a teacher; a policy that is shown it is not to be "
            "scored. `episode_metadata/paraphrases` is not privileged."
        )
    return card.text(
        folder,
        instructions,
        card.Card(
            layout="RLDS",
            command=["rlds", "data", folder.env_id, *(f"--{name}" for name in added)],
            tags=("RLDS", "engram", "mikasa-robo-vla"),
            data_files=None,
            facts={"pictures": "PNG (lossless) of 128 x 128, base and wrist camera"},
            notes=notes,
            use="import tensorflow_datasets as tfds\n\n"
            'builder = tfds.builder_from_directory("FOLDER")\n'
            f'for episode in builder.as_dataset(split="{SPLIT}"):\n'
            '    for step in episode["steps"]:\n'
            '        step["observation"]["image"], step["action"]',
        ),
    )


# --- metadata for tensorflow_datasets ---


def _dataset_info(shard_lengths: list[int], payload_bytes: int) -> dict:
    return {
        "fileFormat": "tfrecord",
        "moduleName": "engram.datasets.rlds",
        "name": NAME,
        "releaseNotes": {VERSION: "Demonstrations of engram's oracle."},
        "splits": [
            {
                "filepathTemplate": "{DATASET}-{SPLIT}.{FILEFORMAT}-{SHARD_X_OF_Y}",
                "name": SPLIT,
                "numBytes": str(payload_bytes),
                "shardLengths": [str(length) for length in shard_lengths],
            }
        ],
        "version": VERSION,
    }
