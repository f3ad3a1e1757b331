"""Labels in data sets, read and checked by LeRobot and tensorflow_datasets as released."""

from __future__ import annotations

import json

import pytest

pytest.importorskip("lerobot")

import numpy as np
import tensorflow_datasets as tfds
from labelled_dataset import (
    MEMORIES,
    PARAPHRASES,
    PLANS,
    PRIVILEGED,
    SUBTASKS,
    labels_of,
    said,
    write_labelled,
)
from lerobot.annotations.steerable_pipeline.reader import iter_episodes
from lerobot.annotations.steerable_pipeline.staging import EpisodeStaging
from lerobot.annotations.steerable_pipeline.validator import StagingValidator
from lerobot.datasets.language_render import active_at, emitted_at
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from sound_dataset import EPISODES, ID, STEPS
from torch.utils.data import DataLoader

from engram.datasets.__main__ import main


@pytest.fixture
def dataset(tmp_path) -> LeRobotDataset:
    write_labelled(tmp_path)
    assert main(["lerobot", str(tmp_path), "--labels", "--images"]) == 0
    return LeRobotDataset("local/test", root=tmp_path / "data_lerobot" / ID)


def test_lerobot_finds_what_is_said_at_each_time(dataset):
    for number in range(EPISODES):
        for step in range(STEPS):
            item = dataset[number * STEPS + step]
            time, rows = item["timestamp"].item(), item["language_persistent"]
            for style, texts in (("subtask", SUBTASKS), ("plan", PLANS), ("memory", MEMORIES)):
                row = active_at(time, persistent=rows, style=style, role="assistant")
                assert (row["content"] if row else "") == said(texts, number)[step]
            wordings = {row["content"] for row in rows if row["style"] == "task_aug"}
            assert wordings == {"Touch the cube.", *PARAPHRASES}
            asked = item["language_events"]
            assert [row["role"] for row in asked] == (["user", "assistant"] if step == 1 else [])
            if asked:
                question, answer = (
                    emitted_at(time, persistent=rows, events=asked, style="vqa", role=role)
                    for role in ("user", "assistant")
                )
                assert question["content"] == "Which object is to be touched?"
                document = json.loads(answer["content"])
                assert document["value"] == said(MEMORIES, number)[step]
                assert document["since_frame"] == 1
            box = item["privileged.object_box"].numpy().reshape(2, 4)
            np.testing.assert_array_equal(box, labels_of(number)["object_box"][step])
            assert bool(item["privileged.is_keyframe"]) == labels_of(number)["is_keyframe"][step]


def test_batches_need_lerobots_collate_function(dataset):
    collate = pytest.importorskip("lerobot.utils.collate").lerobot_collate_fn
    batch = next(iter(DataLoader(dataset, batch_size=4, collate_fn=collate)))
    assert len(batch["action"]) == len(batch["subtask_index"]) == 4
    with pytest.raises(TypeError, match="NoneType"):
        next(iter(DataLoader(dataset, batch_size=4)))
    card = (dataset.root / "README.md").read_text()
    assert "collate_fn=lerobot_collate_fn" in card


def test_lerobots_validator_finds_nothing_wrong(dataset, tmp_path):
    records = list(iter_episodes(dataset.root))
    assert len(records) == EPISODES
    for record in records:
        rows = dataset[record.episode_index * STEPS]["language_persistent"]
        assert len(rows) == 1 + len(PARAPHRASES) + 5
        staging = EpisodeStaging(tmp_path / "staged", record.episode_index)
        staging.write("plan", rows)
        frames = [dataset[record.episode_index * STEPS + step] for step in range(STEPS)]
        staging.write(
            "vqa",
            [
                {**row, "timestamp": time}
                for time, frame in zip(record.frame_timestamps, frames)
                for row in frame["language_events"]
            ],
        )
    validator = StagingValidator(dataset_camera_keys=tuple(dataset.meta.camera_keys))
    report = validator.validate(records, tmp_path / "staged")
    assert (report.episodes_checked, report.errors, report.warnings) == (EPISODES, [], [])


def test_tensorflow_datasets_reads_them(tmp_path):
    write_labelled(tmp_path)
    assert main(["rlds", str(tmp_path), "--labels"]) == 0
    builder = tfds.builder_from_directory(str(tmp_path / "data_rlds" / ID / "1.0.0"))
    for number, record in enumerate(builder.as_dataset(split="train", shuffle_files=False)):
        found = record["episode_metadata"]["paraphrases"].numpy().tolist()
        assert [one.decode() for one in found] == ["Touch the cube.", *PARAPHRASES]
        expected = labels_of(number)
        for index, step in enumerate(record["steps"].as_numpy_iterator()):
            for name in PRIVILEGED[:9]:
                value = step["privileged"][name]
                np.testing.assert_array_equal(value, expected[name][index])
                assert value.dtype == expected[name].dtype
            for style, texts in (("subtask", SUBTASKS), ("plan", PLANS), ("memory", MEMORIES)):
                assert step["privileged"][style].decode() == said(texts, number)[index]
