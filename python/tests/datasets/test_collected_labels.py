"""Labels of `engram collect --labels`, in converted data sets."""

from __future__ import annotations

import json
import subprocess

import pytest
from demonstrations import COMMAND

pytest.importorskip("pyarrow")
pytest.importorskip("av")

import pyarrow.parquet as pq

from engram.datasets import find_folders
from engram.datasets.__main__ import main

# What is said changes, a plan without memory, a task without answers.
IDS = ("RememberColor5-VLA-v0", "TimedTransferEasy-VLA-v0", "InterceptSlow-VLA-v0")


@pytest.fixture(scope="module")
def collected(tmp_path_factory):
    folder = tmp_path_factory.mktemp("labelled")
    command = [*COMMAND, "collect", *IDS, "--episodes=2", "--labels", "--out", folder]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    for words in (["lerobot", "--images"], ["rlds"]):
        name, *options = words
        assert main([name, str(folder), "--labels", *options]) == 0
    return folder


@pytest.mark.parametrize("id", IDS)
def test_every_frame_has_its_subtask(collected, id):
    (folder,) = find_folders(collected, [id])
    root = collected / "data_lerobot" / id
    subtasks = pq.read_table(root / "meta" / "subtasks.parquet").to_pandas()
    rows = [
        row for path in sorted(root.glob("data/*/*")) for row in pq.read_table(path).to_pylist()
    ]
    number = 0
    for episode in folder:
        for words in episode.labels.subtasks():
            assert subtasks.iloc[rows[number]["subtask_index"]].name == words
            number += 1
    assert number == len(rows)


@pytest.mark.parametrize("layout", ["npz", "rlds", "lerobot"])
def test_labelled_sets_are_played_again(collected, layout, capsys):
    assert main(["replay", str(collected), "--format", layout, "--json"]) == 0
    results = json.loads(capsys.readouterr().out)
    assert [result["equal"] for result in results] == [True] * len(IDS)


def test_the_memory_is_empty_until_it_is_shown(collected):
    (folder,) = find_folders(collected, [IDS[0]])
    for episode in folder:
        labels = episode.labels
        assert labels.memories()[-1].startswith("the cue was a ")
        color = labels.memories()[-1].split()[-2]
        first = next(i for i, text in enumerate(labels.memories()) if text)
        said_before = labels.subtasks()[:first] + labels.plans()[:first]
        assert not [text for text in said_before if color in text.split()]
