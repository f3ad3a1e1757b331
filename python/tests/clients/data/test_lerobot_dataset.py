"""LeRobot data sets, read by LeRobot as released."""

from __future__ import annotations

import json

import pytest

pytest.importorskip("lerobot")

import numpy as np
from demonstrations import EPISODES, IDS
from huggingface_hub import DatasetCard
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot_frames import check_frames

from engram.datasets import find_folders
from engram.datasets.__main__ import main
from engram.datasets.spaces import continuous
from engram.integrations.lerobot import EngramEnvConfig, LeRobotEnv


@pytest.mark.parametrize("images", [False, True])
def test_lerobot_reads_every_frame(demonstrations, folder, images, tmp_path):
    path = demonstrations / "data_lerobot" / folder.env_id
    if images:
        words = ["lerobot", str(demonstrations), folder.env_id, "--images"]
        assert main([*words, "--out", str(tmp_path)]) == 0
        path = tmp_path / "data_lerobot" / folder.env_id
    dataset = LeRobotDataset("local/test", root=path, video_backend="pyav")
    assert dataset.fps == 20
    assert dataset.meta.robot_type == "mikasa_robo"
    assert dataset.num_episodes == EPISODES
    assert json.loads((path / "source_rlds_metadata.json").read_text()) == folder.metadata
    for index, episode in enumerate(folder):
        assert dataset.meta.episodes[index]["episode_seed"] == episode.episode_seed
    check_frames(dataset, folder, fps=20, exact=images)


def test_a_second_is_the_same_in_training_and_in_evaluation(demonstrations):
    """Frames one second apart are 20 control steps apart in both, as LeRobot counts them."""
    folder = max(find_folders(demonstrations), key=lambda one: len(one[0]))
    path = demonstrations / "data_lerobot" / folder.env_id
    data = LeRobotDataset(
        "local/test",
        root=path,
        video_backend="pyav",
        delta_timestamps={"observation.state": [-1.0, 0.0], "action": [0.0, 0.05]},
    )
    env = LeRobotEnv(folder.env_id, 1)
    env.close()
    rate = env.unwrapped.metadata["render_fps"]
    assert data.fps == rate == EngramEnvConfig().fps == 20
    states, actions = continuous(folder[0].proprio), folder[0].action
    for now in (rate, len(states) - 1):
        row = data[now]
        np.testing.assert_array_equal(row["observation.state"], states[[now - rate, now]])
        np.testing.assert_array_equal(row["action"][0], actions[now])


def test_the_benchmarks_own_angles_are_kept_by_choice(demonstrations, tmp_path):
    words = [str(demonstrations), IDS[-1], "--images", "--angles", "benchmark"]
    assert main(["lerobot", *words, "--out", str(tmp_path)]) == 0
    path = tmp_path / "data_lerobot" / IDS[-1]
    dataset = LeRobotDataset("local/test", root=path)
    folder = find_folders(demonstrations, [IDS[-1]])[0]
    stored = np.stack([dataset[i]["observation.state"].numpy() for i in range(len(dataset))])
    np.testing.assert_array_equal(stored, np.concatenate([episode.proprio for episode in folder]))
    assert dataset.meta.stats["observation.state"]["std"][3] > 1  # it jumps


def test_hubs_read_the_head_of_its_card(demonstrations):
    card = DatasetCard.load(demonstrations / "data_lerobot" / IDS[0] / "README.md")
    assert card.data.license == "apache-2.0"
    assert card.data.task_categories == ["robotics"]
    assert "LeRobot" in card.data.tags
    assert card.data.configs == [{"config_name": "default", "data_files": "data/*/*.parquet"}]
    assert card.text.strip().startswith(f"# Demonstrations of {IDS[0]}")
