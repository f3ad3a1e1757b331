"""RLDS data sets, read by tensorflow_datasets as released."""

from __future__ import annotations

import json

import pytest

pytest.importorskip("tensorflow_datasets")

import numpy as np
import tensorflow_datasets as tfds
from demonstrations import EPISODES, IDS

from engram.datasets import find_folders, rlds


def test_tensorflow_datasets_reads_every_step(demonstrations, folder):
    path = demonstrations / "data_rlds" / folder.env_id / "1.0.0"
    assert json.loads((path / "metadata.json").read_text()) == folder.metadata
    builder = tfds.builder_from_directory(str(path))
    assert builder.info.full_name == "mikasa_dataset/1.0.0"
    assert builder.info.splits["train"].num_examples == EPISODES
    steps = builder.info.features["steps"]
    assert steps["observation"]["image"].shape == (128, 128, 3)
    assert steps["observation"]["image"].dtype == np.uint8
    assert steps["action"].dtype == np.float32
    read = list(builder.as_dataset(split="train", shuffle_files=False))
    assert len(read) == EPISODES
    for record, episode in zip(read, folder):
        assert record["episode_metadata"]["episode_seed"].numpy() == episode.episode_seed
        assert record["episode_metadata"]["env_id"].numpy().decode() == folder.env_id
        steps = list(record["steps"].as_numpy_iterator())
        assert len(steps) == len(episode)
        for number, step in enumerate(steps):
            observation = step["observation"]
            np.testing.assert_array_equal(observation["image"], episode.image[number])
            np.testing.assert_array_equal(observation["wrist_image"], episode.wrist_image[number])
            np.testing.assert_array_equal(observation["proprio"], episode.proprio[number])
            np.testing.assert_array_equal(step["action"], episode.action[number])
            assert step["reward"] == episode.reward[number]
            assert step["discount"] == (number + 1 < len(episode))  # all succeed
            assert step["language_instruction"].decode() == episode.language_instruction
            assert step["is_first"] == (number == 0)
            assert step["is_last"] == step["is_terminal"] == (number + 1 == len(episode))


def test_records_in_several_shards(demonstrations, monkeypatch, tmp_path):
    folder = find_folders(demonstrations, [IDS[0]])[0]
    monkeypatch.setattr(rlds, "SHARD_BYTES", 1)
    path = rlds.convert(folder, tmp_path, jobs=1)
    assert len(list(path.glob("*.tfrecord-*-of-00002"))) == 2
    builder = tfds.builder_from_directory(str(path))
    assert sum(1 for _ in builder.as_dataset(split="train")) == EPISODES
