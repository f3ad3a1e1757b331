"""Labels of demonstrations in converted data sets."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
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
from sound_dataset import write_sound

pytest.importorskip("pyarrow")
pytest.importorskip("av")
pytest.importorskip("google_crc32c")

import pyarrow.parquet as pq

from engram.datasets import DatasetError, find_folders, lerobot, rlds, tf_example
from engram.datasets.__main__ import main

STYLES = {"subtask": SUBTASKS, "plan": PLANS, "memory": MEMORIES}


def table_of(root: Path) -> tuple[dict, list[dict]]:
    """info.json and the rows of a LeRobot data set."""
    (info,) = root.rglob("info.json")
    tables = [pq.read_table(path) for path in sorted((info.parents[1] / "data").rglob("*.parquet"))]
    return json.loads(info.read_text()), [row for table in tables for row in table.to_pylist()]


def test_words_hold_from_their_step_on(tmp_path):
    write_labelled(tmp_path)
    for number, episode in enumerate(find_folders(tmp_path)[0]):
        assert episode.labels.subtasks() == said(SUBTASKS, number)
        assert episode.labels.plans() == said(PLANS, number)
        assert episode.labels.memories() == said(MEMORIES, number)
        assert episode.labels.objects() == ["", *[f"cube_{('blue', 'red')[number]}"] * 2]


@pytest.mark.parametrize("version", ["3.0", "2.1"])
def test_lerobot_has_them_by_choice(tmp_path, version):
    write_labelled(tmp_path)
    words = ["lerobot", str(tmp_path), "--labels", "--images", "--version", version]
    assert main(words) == 0
    info, rows = table_of(tmp_path)
    assert set(info["features"]) == set(rows[0])
    (file,) = tmp_path.rglob("subtasks.parquet")
    subtasks = pq.read_table(file).to_pandas()
    for number in (0, 1):
        expected = labels_of(number)
        mine = [row for row in rows if row["episode_index"] == number]
        found = [subtasks.iloc[row["subtask_index"]].name for row in mine]
        assert found == said(SUBTASKS, number)
        for name in PRIVILEGED[1:9]:
            values = np.array([row[f"privileged.{name}"] for row in mine])
            np.testing.assert_array_equal(values, expected[name].reshape(values.shape))
        assert ("language_persistent" in mine[0]) == (version == "3.0")
        for step, row in enumerate(mine if version == "3.0" else []):
            assert row["language_persistent"] == mine[0]["language_persistent"]
            assert len(row["language_events"]) == (2 if row["frame_index"] == 1 else 0)
            for style, texts in STYLES.items():
                active = [
                    one
                    for one in row["language_persistent"]
                    if one["style"] == style and one["timestamp"] <= row["timestamp"]
                ]
                text = said(texts, number)[step]
                assert ([one["content"] for one in active] or [""])[-1] == text
            wordings = [
                one["content"] for one in row["language_persistent"] if one["style"] == "task_aug"
            ]
            assert wordings == ["Touch the cube.", *PARAPHRASES]
    (card,) = tmp_path.rglob("data_lerobot/*/README.md")
    assert "**Labels are privileged**" in card.read_text()
    assert " --labels " in card.read_text()


def test_rlds_has_them_by_choice(tmp_path):
    write_labelled(tmp_path)
    assert main(["rlds", str(tmp_path), "--labels", "--jobs", "1"]) == 0
    (shard,) = tmp_path.rglob("*.tfrecord-*")
    with open(shard, "rb") as file:
        records = [tf_example.parse_example(record) for record in tf_example.read_records(file)]
    for number, record in enumerate(records):
        expected = labels_of(number)
        for name in PRIVILEGED[:9]:
            values = np.array(record[f"steps/privileged/{name}"])
            np.testing.assert_array_equal(values, expected[name].ravel().astype(values.dtype))
        for style, texts in STYLES.items():
            found = [text.decode() for text in record[f"steps/privileged/{style}"]]
            assert found == said(texts, number)
        found = [text.decode() for text in record["episode_metadata/paraphrases"]]
        assert found == ["Touch the cube.", *PARAPHRASES]
    (card,) = tmp_path.rglob("data_rlds/*/*/README.md")
    assert "**Labels are privileged**" in card.read_text()


@pytest.mark.parametrize("command", [["rlds"], ["lerobot", "--images"]])
def test_nothing_privileged_is_written_unasked(tmp_path, command):
    write_labelled(tmp_path / "labelled")
    write_sound(tmp_path / "plain")
    for name in ("labelled", "plain"):
        name_of_command, *options = command
        assert main([name_of_command, str(tmp_path / name), *options]) == 0
    sets = [tmp_path / name / f"data_{command[0]}" for name in ("labelled", "plain")]
    files = [{path.relative_to(one) for path in one.rglob("*") if path.is_file()} for one in sets]
    assert files[0] == files[1]
    for file in files[0]:
        contents = [(one / file).read_bytes() for one in sets]
        for word in (b"privileged", b"remember the color", b"the cue was", b"subtask"):
            copies_metadata = file.name in ("metadata.json", "source_rlds_metadata.json")
            assert word not in contents[0] or copies_metadata, file
        if file.suffix in (".parquet",) or "tfrecord" in file.name:
            assert contents[0] == contents[1]


def test_sets_without_labels_are_refused(tmp_path):
    write_sound(tmp_path)
    (folder,) = find_folders(tmp_path)
    for convert in (rlds.convert, lerobot.convert):
        with pytest.raises(DatasetError, match=r"labels: .* has none; `engram collect --labels`"):
            convert(folder, tmp_path, labels=True)
    assert [path.name for path in tmp_path.iterdir()] == ["data_npz"]


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("subtask_index", np.array([0, 1, 7], np.int32), "subtask_index: 7 in step 2"),
        ("subtask_index", np.array([0, 1], np.int32), "subtask_index is int32 of shape"),
        ("subtask_index", np.array([0.0, 1, 1]), "subtask_index is float64"),
        ("progress", np.array([0, np.nan, 1], np.float32), "progress: a value that is not finite"),
        ("object_index", np.array([0, 1, 2], np.int32), "object_index: 2, of 2 objects"),
        ("object_index", np.array([0, 1, -2], np.int32), "object_index"),
        ("object_box", np.zeros((3, 2, 5), np.int32), "object_box is int32 of shape"),
        ("plan_step", np.array([1, 1, 2, 2], np.int32), "plan: nothing holds at the first step"),
        ("plan_step", np.array([0, 0, 2, 1], np.int32), "plan_step: .* in order"),
        ("plan_index", np.array([0, 1, 0], np.int32), "plan_index: 3 numbers of 4 texts"),
        ("memory_step", np.array([3], np.int32), "memory_step: .* steps from 0 to 2"),
        ("memory", np.array(["\x1b[2Jx"]), "memory: .* control characters"),
        ("paraphrases", np.array(["x" * 20_000]), "paraphrases is <U20000"),
        ("paraphrases", np.array([["two", "rows"]]), "paraphrases is <U4 of shape"),
        ("object_names", np.array([None, "x"], object), "object_names is object"),
    ],
)
def test_damaged_labels_are_refused(tmp_path, name, value, words):
    folder = write_labelled(tmp_path, **{name: value})
    with pytest.raises(DatasetError, match=rf"train_data_1\.npz'.*{words}"):
        find_folders(tmp_path)[0][1]
    np.savez(folder / "train_data_1.npz", **{})
    with pytest.raises(DatasetError, match=r"train_data_1\.npz"):
        find_folders(tmp_path)[0][1]


def test_an_instruction_without_paraphrases(tmp_path):
    empty = np.array([], "<U1")
    write_labelled(tmp_path, paraphrases=empty, memory=empty, memory_step=np.array([], np.int32))
    (folder,) = find_folders(tmp_path)
    assert folder[1].labels.memories() == ["", "", ""]
    assert main(["rlds", str(tmp_path), "--labels"]) == 0
    assert main(["lerobot", str(tmp_path), "--labels", "--images"]) == 0
    _, rows = table_of(tmp_path)
    styles = {one["style"] for one in rows[-1]["language_persistent"]}
    assert styles == {"task_aug", "subtask", "plan"}
