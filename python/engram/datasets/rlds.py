"""Writes demonstrations as RLDS: TFRecord files that tensorflow_datasets reads.

One episode is one record: a tf.train.Example in which every field of `steps` is a list over the
steps. Images are PNG, so that nothing is lost.
"""

from __future__ import annotations

import json
import math
import shutil
from collections.abc import Callable
from pathlib import Path

from engram.datasets import tf_example
from engram.datasets.episodes import DemonstrationFolder, Episode, no_progress
from engram.datasets.work import in_order, new_folder, png

NAME = "mikasa_dataset"
VERSION = "1.0.0"
SPLIT = "train"
SHARD_BYTES = 256 << 20  # of .npz files that go into one shard, about


def convert(
    folder: DemonstrationFolder,
    root: Path | str,
    jobs: int = 0,
    progress: Callable[[int, int], None] = no_progress,
) -> Path:
    """Writes <root>/data_rlds/<id>/1.0.0 and returns its path.

    The folder appears when it is complete; one that is there already is replaced. jobs: threads
    that encode, 0 for one per core; progress is called with the episodes done and all of them.
    """
    target = Path(root) / "data_rlds" / folder.env_id / VERSION
    lengths = _shard_lengths(folder)
    with new_folder(target) as path:
        records = in_order(_record, [(file, folder.env_id) for file in folder.files], jobs)
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
        first = folder[0]
        _write_json(path / "features.json", _features(first.image.shape[1:], first.action.shape[1]))
        _write_json(path / "dataset_info.json", _dataset_info(lengths, payload_bytes))
        shutil.copyfile(folder.metadata_path, path / "metadata.json")
    return target


def _shard_lengths(folder: DemonstrationFolder) -> list[int]:
    total = sum(file.stat().st_size for file in folder.files)
    shards = min(len(folder), max(1, math.ceil(total / SHARD_BYTES)))
    edges = [len(folder) * i // shards for i in range(shards + 1)]
    return [end - begin for begin, end in zip(edges, edges[1:])]


def _record(source: tuple[Path, str]) -> bytes:
    path, env_id = source
    return serialize(Episode.load(path), env_id)


def serialize(episode: Episode, env_id: str) -> bytes:
    """One episode as a tf.train.Example."""
    steps = len(episode)
    last = [0] * (steps - 1) + [1]
    return tf_example.serialize_example(
        {
            "steps/observation/image": [png(image) for image in episode.image],
            "steps/observation/wrist_image": [png(image) for image in episode.wrist_image],
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


def _class(name: str) -> dict:
    return {"pythonClassName": f"tensorflow_datasets.core.features.{name}"}


def _tensor(dtype: str, *shape: int) -> dict:
    kind = "tensor_feature.Tensor" if shape else "scalar.Scalar"
    dimensions = {"dimensions": [str(size) for size in shape]} if shape else {}
    return _class(kind) | {"tensor": {"dtype": dtype, "encoding": "none", "shape": dimensions}}


def _image(shape: tuple[int, ...]) -> dict:
    return _class("image_feature.Image") | {
        "image": {
            "dtype": "uint8",
            "encodingFormat": "png",
            "shape": {"dimensions": [str(size) for size in shape]},
        }
    }


def _text() -> dict:
    return _class("text_feature.Text") | {"text": {}}


def _dict(**features: dict) -> dict:
    return _class("features_dict.FeaturesDict") | {"featuresDict": {"features": features}}


def _features(image_shape: tuple[int, ...], action_dim: int) -> dict:
    steps = _dict(
        observation=_dict(
            image=_image(image_shape),
            wrist_image=_image(image_shape),
            proprio=_tensor("float32", 7),
        ),
        action=_tensor("float32", action_dim),
        reward=_tensor("float32"),
        discount=_tensor("float32"),
        is_first=_tensor("bool"),
        is_last=_tensor("bool"),
        is_terminal=_tensor("bool"),
        language_instruction=_text(),
    )
    return _dict(
        steps=_class("dataset_feature.Dataset") | {"sequence": {"feature": steps, "length": "-1"}},
        episode_metadata=_dict(env_id=_text(), episode_seed=_tensor("int64")),
    )


def _write_json(path: Path, document: dict) -> None:
    path.write_text(json.dumps(document, indent=2) + "\n")
