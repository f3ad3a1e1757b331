"""LeRobot data sets, read by LeRobot as released."""

from __future__ import annotations

import json

import pytest

pytest.importorskip("lerobot")

import numpy as np
from demonstrations import EPISODES
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from engram.datasets.__main__ import main


@pytest.mark.parametrize("images", [False, True])
def test_lerobot_reads_every_frame(demonstrations, folder, images, tmp_path):
    path = demonstrations / "data_lerobot" / folder.env_id
    if images:
        assert (
            main(
                [
                    "lerobot",
                    str(demonstrations),
                    folder.env_id,
                    "--images",
                    "--out",
                    str(tmp_path),
                    "--fps",
                    "20",
                ]
            )
            == 0
        )
        path = tmp_path / "data_lerobot" / folder.env_id
    dataset = LeRobotDataset("local/test", root=path, video_backend="pyav")
    assert dataset.fps == 20
    assert dataset.meta.robot_type == "mikasa_robo"
    assert dataset.num_episodes == EPISODES
    assert len(dataset) == sum(folder.metadata["episode_lengths"])
    assert json.loads((path / "source_rlds_metadata.json").read_text()) == folder.metadata
    state_stats = dataset.meta.stats["observation.state"]
    number = 0
    for index, episode in enumerate(folder):
        assert dataset.meta.episodes[index]["episode_seed"] == episode.episode_seed
        for step in range(len(episode)):
            item = dataset[number]
            number += 1
            np.testing.assert_array_equal(item["observation.state"].numpy(), episode.proprio[step])
            np.testing.assert_array_equal(item["action"].numpy(), episode.action[step])
            assert item["task"] == episode.language_instruction
            assert (item["episode_index"], item["frame_index"]) == (index, step)
            assert item["timestamp"].item() == pytest.approx(step / 20)
            assert (episode.proprio[step] >= state_stats["min"]).all()
            for key, image in (("top", episode.image[step]), ("wrist", episode.wrist_image[step])):
                seen = item[f"observation.images.{key}"].permute(1, 2, 0).numpy() * 255
                assert seen.shape == (128, 128, 3)
                error = np.abs(seen - image)
                # Videos are lossy, but show the right frame: neighbours in the wrist camera, which
                # moves, differ by more. Images are exact.
                assert error.max() < 0.01 if images else error.mean() < 9, (key, index, step)
