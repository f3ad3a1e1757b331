"""A sound data set with labels, written by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from sound_dataset import EPISODES, ID, STEPS, arrays_of, metadata_text, sound_metadata

COLORS = ("blue", "red")
PARAPHRASES = ["Look at the cube and touch one like it.", "Find the same cube again."]
PRIVILEGED = [
    "subtask_index", "is_keyframe", "progress", "object_index", "object_box", "object_point",
    "answered", "first_answer", "first_answer_correct",
    "plan", "plan_step", "plan_index", "memory", "memory_step", "object_names",
]  # fmt: skip

# What is said in each of the three steps.
SUBTASKS = ["remember the color", "touch the {} cube", "touch the {} cube"]
PLANS = [
    "1. remember the color\n2. touch the cube of that color",
    "1. touch the {} cube",
    "1. touch the {} cube",
]
MEMORIES = ["", "the cue was a {} cube", "the cue was a {} cube"]


def said(texts: list[str], number: int) -> list[str]:
    """The texts of episode `number`."""
    return [text.format(COLORS[number]) for text in texts]


def labels_of(number: int) -> dict[str, np.ndarray]:
    """The arrays of labels of a sound episode."""
    rng = np.random.default_rng(number)
    color = COLORS[number]
    return {
        "subtask_index": np.array([0, 1, 1], np.int32),
        "is_keyframe": np.array([True, True, False]),
        "progress": np.array([0, 0.5, 0.5], np.float32),
        "object_index": np.array([-1, number, number], np.int32),
        "object_box": rng.integers(-1, 128, (STEPS, 2, 4), np.int32),
        "object_point": rng.integers(-1, 128, (STEPS, 2, 3), np.int32),
        "answered": np.array([False, False, True]),
        "first_answer": np.array([0, 0, number], np.int32),
        "first_answer_correct": np.array([False, False, True]),
        "plan": np.array(
            [
                "remember the color",
                "touch the cube of that color",
                "remember the color",
                f"touch the {color} cube",
            ]
        ),
        "plan_step": np.array([0, 0, 1, 1], np.int32),
        "plan_index": np.array([0, 1, 0, 1], np.int32),
        "memory": np.array([f"the cue was a {color} cube"]),
        "memory_step": np.array([1], np.int32),
        "object_names": np.array([f"cube_{name}" for name in COLORS]),
        "paraphrases": np.array(PARAPHRASES),
    }


def write_labelled(root: Path, **changes: np.ndarray) -> Path:
    """Writes the set below root; changes: other arrays in its last episode."""
    folder = root / "data_npz" / ID
    folder.mkdir(parents=True, exist_ok=True)
    for number in range(EPISODES):
        arrays = arrays_of(number) | labels_of(number)
        if number == EPISODES - 1:
            arrays |= changes
        np.savez_compressed(folder / f"train_data_{number}.npz", **arrays)
    document = sound_metadata()
    document["engram"]["labels"] = {"privileged": PRIVILEGED, "open": ["paraphrases"]}
    (folder / "metadata.json").write_text(metadata_text(document))
    return folder
