"""Questions about the past, in data sets with labels."""

from __future__ import annotations

import json
import subprocess

import numpy as np
import pytest
from demonstrations import COMMAND
from labelled_dataset import labels_of

pytest.importorskip("pyarrow")

from engram.datasets import find_folders
from engram.datasets.labels import Labels
from engram.datasets.lerobot import questions

IDS = {
    "RememberColor3-VLA-v0": "Which object is to be touched?",
    "SeqOfColors3-VLA-v0": "Which cubes are to be touched?",
    "RotateLenientPos-VLA-v0": None,  # has no list of answers
}


def labels(number: int = 0) -> Labels:
    arrays = labels_of(number)
    names = ("plan", "memory", "object_names", "paraphrases")
    steps = {name: arrays[name] for name in list(arrays)[:9]}
    texts = {name: arrays[name].tolist() for name in names}
    numbers = {name: arrays[name] for name in ("plan_step", "plan_index", "memory_step")}
    return Labels(steps, **texts, **numbers)


def test_questions_are_those_of_the_task():
    assert {id: questions.question_of(id) for id in IDS} == IDS
    assert questions.question_of("Elsewhere-v0") is None


def test_a_question_has_its_answer_and_the_frame_that_showed_it():
    first, second, third = questions.rows(labels(), "Which one?")
    assert first == third == []
    assert [row["role"] for row in second] == ["user", "assistant"]
    assert second[0]["content"] == "Which one?"
    assert json.loads(second[1]["content"]) == {
        "label": "past",
        "attribute": "shown",
        "value": "the cue was a blue cube",
        "since_frame": 1,
    }
    assert {row["camera"] for row in second} == {"observation.images.top"}


@pytest.mark.parametrize("question", [None, "Which?"])
def test_nothing_is_told_before_it_was_shown(tmp_path, question):
    command = [*COMMAND, "collect", *IDS, "--episodes=1", "--labels", "--out", tmp_path]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    for folder in find_folders(tmp_path):
        for episode in folder:
            rows = questions.rows(episode.labels, question)
            memories = episode.labels.memories()
            asked = [step for step, pair in enumerate(rows) if pair]
            assert asked
            assert asked[0] == episode.labels.memory_step[0]
            for step in asked:
                document = json.loads(rows[step][1]["content"])
                assert document["value"] == memories[step]
                assert document["since_frame"] <= step
                since = memories[document["since_frame"] : step + 1]
                assert set(since) == {document["value"]}
                if rows[step][0]["content"] == question:  # nothing more is shown
                    assert set(memories[step:]) == {document["value"]}
            new = [s for s in np.unique(episode.labels.memory_step) if memories[s]]
            assert set(new) <= set(asked)
