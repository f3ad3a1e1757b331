"""Writes demonstrations as RLDS: TFRecord files that tensorflow_datasets reads.

One episode is one record: a tf.train.Example in which every field of `steps` is a list over the
steps. Images are PNG, so that nothing is lost.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path

from engram.datasets import card, checks, tf_example
from engram.datasets.episodes import (
    RLDS_FOLDER,
    RLDS_VERSION,
    DemonstrationFolder,
    Episode,
    no_progress,
)
from engram.datasets.folders import new_folder
from engram.datasets.rlds_features import features, label_values
from engram.datasets.work import in_order, pngs

NAME = "mikasa_dataset"
VERSION = RLDS_VERSION
SPLIT = "train"
SHARD_BYTES = 256 << 20  # of .npz files that go into one shard, about


def convert(
    folder: DemonstrationFolder,
    root: Path | str,
    jobs: int = 0,
    progress: Callable[[int, int], None] = no_progress,
    *,
    labels: bool = False,
) -> Path:
    """Writes <root>/data_rlds/<id>/1.0.0 and returns its path.

    The folder appears when it is complete; one that was written here before is replaced. jobs:
    threads that encode, 0 for one per core; progress is called with the episodes done and all of
    them; labels: adds those of the demonstrations, which are privileged. Raises DatasetError, and
    leaves everything as it was, if an episode is damaged.
    """
    checks.whole_number("jobs", jobs, 0, checks.MAX_JOBS)
    if labels:
        folder.require_labels()
    lengths = _shard_lengths(folder)
    place = (RLDS_FOLDER, folder.env_id, VERSION)
    with new_folder(root, *place) as path:
        instructions: set[str] = set()

        def record_of(index: int) -> bytes:
            episode = folder[index]
            instructions.add(episode.language_instruction)
            return serialize(episode, folder.env_id, labels)

        records = in_order(record_of, range(len(folder)), jobs)
        payload_bytes = 0
        done = 0
        for shard, length in enumerate(lengths):
            name = f"{NAME}-{SPLIT}.tfrecord-{shard:05d}-of-{len(lengths):05d}"
            with open(path / name, "wb") as file:
                for _ in range(length):
                    record = next(records)
                    tf_example.write_record(file, record)
                    payload_bytes += len(record)
                    done += 1
                    progress(done, len(folder))
        described = features(folder.spaces, folder[0].labels if labels else None)
        _write_json(path / "features.json", described)
        _write_json(path / "dataset_info.json", _dataset_info(lengths, payload_bytes))
        (path / "metadata.json").write_bytes(folder.metadata_bytes)
        (path / "README.md").write_text(_card(folder, sorted(instructions), labels))
    return Path(root).joinpath(*place)


def _shard_lengths(folder: DemonstrationFolder) -> list[int]:
    total = sum(file.stat().st_size for file in folder.files)
    shards = min(len(folder), max(1, math.ceil(total / SHARD_BYTES)))
    edges = [len(folder) * i // shards for i in range(shards + 1)]
    return [end - begin for begin, end in zip(edges, edges[1:])]


def serialize(episode: Episode, env_id: str, labels: bool = False) -> bytes:
    """One episode as a tf.train.Example."""
    steps = len(episode)
    last = [0] * (steps - 1) + [1]
    fields = {
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
    if labels and episode.labels is not None:
        fields |= label_values(episode.labels, episode.language_instruction)
    return tf_example.serialize_example(fields)


def _card(folder: DemonstrationFolder, instructions: list[str], labels: bool) -> str:
    spaces = folder.spaces
    notes = [
        f"`steps/observation/proprio`, before the action: {', '.join(spaces.proprio_names)}"
        + (".", "; angles are the benchmark's, from -pi to pi.")[not spaces.joint_proprio],
        f"`steps/action`: {', '.join(spaces.action_names)}.",
    ]
    if labels:
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
            command=["rlds", "data", folder.env_id, *(["--labels"] if labels else [])],
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


def _write_json(path: Path, document: dict) -> None:
    path.write_text(json.dumps(document, indent=2) + "\n")
