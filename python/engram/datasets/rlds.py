"""Writes demonstrations as RLDS: TFRecord files that tensorflow_datasets reads.

One episode is one record: a tf.train.Example in which every field of `steps` is a list over the
steps. Images are PNG, so that nothing is lost.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO

from engram.datasets import additions, card, frozen, source, tf_example
from engram.datasets.collected import EpisodeSource
from engram.datasets.conversion import Writer
from engram.datasets.episodes import RLDS_FOLDER, RLDS_VERSION, Episode
from engram.datasets.frozen import FrozenCue
from engram.datasets.labels import Labels
from engram.datasets.rlds_features import features, label_values
from engram.datasets.work import pngs

NAME = "mikasa_dataset"
VERSION = RLDS_VERSION
SPLIT = "train"
SHARD_BYTES = 256 << 20  # after which the next shard begins


class _Writer(Writer):
    """Files of records. Their names say how many there are, which is known at the end."""

    PLACE = (RLDS_FOLDER, "{}", VERSION)
    _bytes = 0
    _file: BinaryIO | None = None
    _labels: Labels | None = None  # of the last episode
    _rows: Mapping[str, int]  # widths

    def start(self) -> None:
        self._lengths: list[int] = []  # of files, in records
        self.callback(self._name_files)

    def _name_files(self) -> None:
        if self._file is not None:
            self._file.close()
        for shard in range(len(self._lengths)):
            self._shard(shard).rename(self._shard(shard, len(self._lengths)))

    def pack(self, episode: Episode) -> tuple[bytes, Labels | None, dict[str, int]]:
        widths = {name: values.shape[1] for name, values in episode.rows(self.added).items()}
        record = serialize(episode, self.folder.env_id, self.added, self.cue)
        return record, episode.labels, widths

    def add(self, packed: tuple[bytes, Labels | None, dict[str, int]]) -> None:
        record, self._labels, self._rows = packed
        if self._file is None or self._file.tell() >= SHARD_BYTES:
            if self._file is not None:
                self._file.close()
            self._file = open(self._shard(len(self._lengths)), "wb")  # noqa: SIM115 (_name_files)
            self._lengths.append(0)
        tf_example.write_record(self._file, record)
        self._bytes += len(record)
        self._lengths[-1] += 1

    def finish(self) -> card.Card:
        labels = self._labels if additions.LABELS in self.added else None
        described = features(self.folder.spaces, self.added, labels, bool(self.cue), self._rows)
        source.write_json(self.path / "features.json", described)
        source.write_json(
            self.path / "dataset_info.json", _dataset_info(self._lengths, self._bytes)
        )
        return _card(self.folder, self.added, bool(self.cue))

    def _shard(self, shard: int, shards: int | None = None) -> Path:
        name = f"{NAME}-{SPLIT}.tfrecord-{shard:05d}"
        return self.path / (name if shards is None else f"{name}-of-{shards:05d}")


convert = _Writer.convert
is_written = _Writer.is_written


def serialize(
    episode: Episode, env_id: str, added: Collection[str] = (), cue: FrozenCue | None = None
) -> bytes:
    """One episode as a tf.train.Example, with these additions."""
    steps = len(episode)
    before = steps - 1
    # A kept failure that is as long as episodes may be was truncated.
    horizon = cue.horizon if cue is not None else None
    terminal = episode.success_once or (horizon is not None and steps < horizon)
    fields: dict[str, Sequence[Any]] = {
        "steps/observation/image": pngs(episode.image),
        "steps/observation/wrist_image": pngs(episode.wrist_image),
        "steps/observation/proprio": episode.proprio.ravel().tolist(),
        "steps/action": episode.action.ravel().tolist(),
        "steps/reward": episode.reward.tolist(),
        "steps/discount": [1.0] * before + [0.0 if terminal else 1.0],
        "steps/is_first": [1] + [0] * before,
        "steps/is_last": [0] * before + [1],
        "steps/is_terminal": [0] * before + [int(terminal)],
        "steps/language_instruction": [episode.language_instruction.encode()] * steps,
        "episode_metadata/env_id": [env_id.encode()],
        "episode_metadata/episode_seed": [episode.episode_seed],
    }
    for name, values in episode.maps(added).items():
        for camera, key in enumerate(additions.map_keys(name)):
            fields[f"steps/observation/{key}"] = pngs(values[..., camera])
    for name, values in episode.rows(added).items():
        fields[f"steps/observation/{name}"] = values.ravel().tolist()
    if additions.SEGMENTATION in added and episode.segmentation_names is not None:
        names = [name.encode() for name in episode.segmentation_names]
        fields[f"episode_metadata/{additions.SEGMENT_NAMES}"] = names
    if cue:
        fields[f"steps/{frozen.COLUMN}"] = cue.mask(episode).astype(int).tolist()
    if additions.LABELS in added and episode.labels is not None:
        fields |= label_values(episode.labels, episode.language_instruction)
    return tf_example.serialize_example(fields)


def _card(folder: EpisodeSource, added: Collection[str], is_frozen: bool) -> card.Card:
    fields = "steps/observation/proprio", "steps/action"
    return card.of_steps(
        folder,
        added,
        (*fields, "steps/privileged", "episode_metadata/paraphrases"),
        card.map_notes(added, "`steps/observation/{}`, `wrist_{}`", "`episode_metadata`")
        + frozen.notes(is_frozen, fields[1], f"steps/{frozen.COLUMN}"),
        layout="RLDS",
        command="rlds",
        tags=("RLDS", "engram", "mikasa-robo-vla"),
        facts={"pictures": "PNG (lossless) of 128 x 128, base and wrist camera"},
        use="import tensorflow_datasets as tfds\n\n"
        'builder = tfds.builder_from_directory("FOLDER")\n'
        f'for episode in builder.as_dataset(split="{SPLIT}"):\n'
        '    for step in episode["steps"]:\n'
        '        step["observation"]["image"], step["action"]',
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
