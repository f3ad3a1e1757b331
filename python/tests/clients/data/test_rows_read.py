"""Rows of state and objects in data sets, read by LeRobot and tensorflow_datasets as released."""

from __future__ import annotations

import subprocess
import sys

import pytest

pytest.importorskip("lerobot")

import numpy as np
import tensorflow_datasets as tfds
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.utils.feature_utils import dataset_to_policy_features

from engram.datasets import find_folders
from engram.datasets.__main__ import main

ID = "RememberColor3-VLA-v0"


@pytest.mark.parametrize("name", ["state", "objects"])
def test_both_read_them_exactly(tmp_path, name):
    words = ["collect", ID, "--episodes", "2", f"--{name}", "--out", str(tmp_path)]
    subprocess.run([sys.executable, "-m", "engram", *words], check=True, capture_output=True)
    (folder,) = find_folders(tmp_path)
    expected = np.concatenate([getattr(episode, name) for episode in folder])

    assert main(["lerobot", str(tmp_path), f"--{name}"]) == 0
    root = tmp_path / "data_lerobot" / ID
    dataset = LeRobotDataset("local/test", root=root, video_backend="pyav")
    key = {"state": "privileged.state", "objects": "objects"}[name]
    found = np.stack([dataset[i][key].numpy() for i in range(len(dataset))])
    np.testing.assert_array_equal(found, expected)
    assert key not in dataset_to_policy_features(dataset.meta.features)

    assert main(["rlds", str(tmp_path), f"--{name}"]) == 0
    builder = tfds.builder_from_directory(str(tmp_path / "data_rlds" / ID / "1.0.0"))
    records = builder.as_dataset(split="train", shuffle_files=False)
    steps = [step for record in records for step in record["steps"].as_numpy_iterator()]
    np.testing.assert_array_equal([step["observation"][name] for step in steps], expected)
