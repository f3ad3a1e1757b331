"""LeRobot data sets of version 2.1, read by the last LeRobot that reads them, as released."""

from __future__ import annotations

import json

import pytest

pytest.importorskip("lerobot")

import lerobot
import numpy as np
import pyarrow.parquet as pq
from demonstrations import EPISODES
from labelled_dataset import SUBTASKS, labels_of, said, write_labelled
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot_frames import check_frames
from mapped_dataset import MAPS, maps_of, write_mapped
from sound_dataset import ID, STEPS

from engram.datasets.__main__ import main


def convert(demonstrations, id, out, *options) -> LeRobotDataset:
    words = ["lerobot", str(demonstrations), id, "--version", "2.1", "--out", str(out)]
    assert main([*words, *options]) == 0
    return LeRobotDataset("local/test", root=out / "data_lerobot" / id)


def test_this_is_the_reader_of_that_version():
    assert lerobot.__version__ == "0.3.3"


@pytest.mark.parametrize("frames", ["videos", "images"])
def test_lerobot_reads_every_frame(demonstrations, folder, frames, tmp_path):
    dataset = convert(demonstrations, folder.env_id, tmp_path, "--frames", frames)
    assert dataset.meta.info["codebase_version"] == "v2.1"
    assert (dataset.fps, dataset.num_episodes) == (20, EPISODES)
    assert dataset.meta.robot_type == "mikasa_robo"
    for index, episode in enumerate(folder):
        assert dataset.meta.episodes[index]["episode_seed"] == episode.episode_seed
    check_frames(dataset, folder, fps=20, exact=frames == "images")
    if frames == "videos":
        assert dataset.features["observation.images.top"]["info"]["video.codec"] == "h264"


def test_chunks_of_actions_are_those_of_the_episode(demonstrations, folder, tmp_path):
    convert(demonstrations, folder.env_id, tmp_path, "--images")
    root = tmp_path / "data_lerobot" / folder.env_id
    chunk = {"action": [i / 20 for i in range(4)]}
    dataset = LeRobotDataset("local/test", root=root, delta_timestamps=chunk)
    episode = folder[1]
    last = dataset[len(dataset) - 2]
    np.testing.assert_array_equal(last["action"][:2].numpy(), episode.action[-2:])
    assert last["action_is_pad"].tolist() == [False, False, True, True]


def test_gr00t_finds_its_parts(demonstrations, folder, tmp_path):
    dataset = convert(demonstrations, folder.env_id, tmp_path, "--modality", "gr00t")
    meta = dataset.root / "meta"
    modality = json.loads((meta / "modality.json").read_text())
    assert set(modality) == {"state", "action", "video", "annotation"}
    for group, column in (("state", "observation.state"), ("action", "action")):
        names = dataset.features[column]["names"]
        parts = modality[group].values()
        covered = [i for part in parts for i in range(part["start"], part["end"])]
        assert sorted(covered) == list(range(len(names)))
    start, end = (modality["state"]["rotation"][name] for name in ("start", "end"))
    assert dataset.features["observation.state"]["names"][start:end] == ["roll", "pitch", "yaw"]
    for part in modality["video"].values():
        assert dataset.features[part["original_key"]]["dtype"] == "video"
    tasks = [json.loads(line)["task"] for line in (meta / "tasks.jsonl").read_text().splitlines()]
    for key in modality["annotation"]:
        for number, episode in enumerate(folder):
            table = pq.read_table(dataset.root / dataset.meta.get_data_file_path(number))
            said = table.column(f"annotation.{key}").to_pylist()
            assert {tasks[i] for i in said} == {episode.language_instruction}
    assert dataset[0]["annotation.human.task_description"] == 0
    # Statistics that GR00T normalises by, in a file as of version 2.0.
    stats = json.loads((meta / "stats.json").read_text())
    assert min(stats["action"]["std"]) >= 0.01 * (1 - 1e-9)


def test_labels_are_numbers_and_names(tmp_path):
    write_labelled(tmp_path)
    assert main(["lerobot", str(tmp_path), "--labels", "--images", "--version", "2.1"]) == 0
    dataset = LeRobotDataset("local/test", root=tmp_path / "data_lerobot" / ID)
    subtasks = pq.read_table(dataset.root / "meta" / "subtasks.parquet").to_pandas()
    for number in range(2):
        for step in range(STEPS):
            item = dataset[number * STEPS + step]
            words = subtasks.iloc[int(item["subtask_index"])].name
            assert words == said(SUBTASKS, number)[step]
            box = item["privileged.object_box"].numpy().reshape(2, 4)
            np.testing.assert_array_equal(box, labels_of(number)["object_box"][step])
            assert item["privileged.progress"].item() == labels_of(number)["progress"][step]


def test_depth_and_segmentation_come_exactly(tmp_path):
    write_mapped(tmp_path)
    dataset = convert(tmp_path, ID, tmp_path, *(f"--{name}" for name in MAPS))
    for number in (0, 1):
        for step in range(STEPS):
            item = dataset[number * STEPS + step]
            for name in MAPS:
                for index, camera in enumerate(("top", "wrist")):
                    found = item[f"observation.images.{camera}_{name}"]
                    assert found.shape == (1, 128, 128)
                    expected = maps_of(number)[name][step, ..., index]
                    np.testing.assert_array_equal(found[0].numpy(), expected)
