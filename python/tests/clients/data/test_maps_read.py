"""Depth and segmentation in data sets, read by LeRobot and tensorflow_datasets as released."""

from __future__ import annotations

import pytest

pytest.importorskip("lerobot")

import numpy as np
import tensorflow_datasets as tfds
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from mapped_dataset import MAPS, NAMES, maps_of, write_mapped
from sound_dataset import EPISODES, ID, STEPS

from engram.datasets.__main__ import main

OPTIONS = [f"--{name}" for name in MAPS]


@pytest.mark.parametrize("frames", ["images", "videos"])
def test_lerobot_reads_them_exactly(tmp_path, frames):
    write_mapped(tmp_path)
    assert main(["lerobot", str(tmp_path), *OPTIONS, "--frames", frames]) == 0
    root = tmp_path / "data_lerobot" / ID
    dataset = LeRobotDataset("local/test", root=root, video_backend="pyav")
    in_metres = LeRobotDataset("local/test", root=root, video_backend="pyav", depth_output_unit="m")
    depths = {f"observation.images.{camera}_depth" for camera in ("top", "wrist")}
    assert set(dataset.meta.depth_keys) == depths
    names = dataset.meta.features["observation.images.top_segmentation"]["info"]
    assert names["segmentation_names"] == NAMES
    for number in range(EPISODES):
        for step in range(STEPS):
            item = dataset[number * STEPS + step]
            for name in MAPS:
                for index, camera in enumerate(("top", "wrist")):
                    key = f"observation.images.{camera}_{name}"
                    assert item[key].shape == (1, 128, 128)
                    expected = maps_of(number)[name][step, ..., index]
                    np.testing.assert_array_equal(item[key][0].numpy(), expected)
            depth = in_metres[number * STEPS + step]["observation.images.top_depth"][0].numpy()
            np.testing.assert_allclose(
                depth, maps_of(number)["depth"][step, ..., 0] / 1000, rtol=1e-6
            )
    stats = dataset.meta.stats["observation.images.top_depth"]
    assert np.asarray(stats["mean"]).shape == (1, 1, 1)
    assert np.asarray(in_metres.meta.stats["observation.images.top_depth"]["max"]) == (
        pytest.approx(np.asarray(stats["max"]) / 1000)
    )


def test_tensorflow_datasets_reads_them_exactly(tmp_path):
    write_mapped(tmp_path)
    assert main(["rlds", str(tmp_path), *OPTIONS]) == 0
    builder = tfds.builder_from_directory(str(tmp_path / "data_rlds" / ID / "1.0.0"))
    for number, record in enumerate(builder.as_dataset(split="train", shuffle_files=False)):
        found = record["episode_metadata"]["segmentation_names"].numpy().tolist()
        assert [one.decode() for one in found] == NAMES
        for index, step in enumerate(record["steps"].as_numpy_iterator()):
            for name in MAPS:
                for camera, key in enumerate((name, f"wrist_{name}")):
                    value = step["observation"][key]
                    assert value.dtype == np.uint16
                    expected = maps_of(number)[name][index, ..., camera, None]
                    np.testing.assert_array_equal(value, expected)
