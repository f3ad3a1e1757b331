"""Labels as columns of a LeRobotDataset: LeRobot's language and subtasks, and numbers.

`language_persistent` holds all rows of an episode in each of its frames; readers choose those that
are active at the frame's time. LeRobot 0.5 looks up `subtask_index` in meta/subtasks.parquet.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pyarrow as pa

from engram.datasets.labels import STEP_FIELDS, Labels
from engram.datasets.lerobot import questions

SUBTASK = "subtask_index"
PERSISTENT, EVENTS = "language_persistent", "language_events"
_PREFIX = "privileged."  # of columns that have no name of LeRobot's
_DTYPES: dict[type, str] = {np.bool_: "bool", np.int32: "int64", np.float32: "float32"}
_EDGES = ("left", "top", "right", "bottom")
_POINT = ("column", "row", "depth_mm")
_CAMERA_NAMES = ("top", "wrist")
_NAMES = {
    "object_box": [f"{camera}_{edge}" for camera in _CAMERA_NAMES for edge in _EDGES],
    "object_point": [f"{camera}_{part}" for camera in _CAMERA_NAMES for part in _POINT],
}

# --- numbers ---


def numbers(labels: Labels, vocabulary: dict[str, int]) -> dict[str, np.ndarray]:
    """Columns by name. vocabulary: indices of subtasks by their words; new ones are added."""
    indices = [vocabulary.setdefault(words, len(vocabulary)) for words in labels.subtasks()]
    columns = {SUBTASK: np.array(indices, np.int64)}
    for name, values in labels.steps.items():
        if name != SUBTASK:
            flat = values.reshape(len(values), -1) if values.ndim > 1 else values
            columns[_PREFIX + name] = flat.astype(_DTYPES[STEP_FIELDS[name][0]])
    return columns


def features(columns: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Entries of info.json for those of the columns that hold labels."""
    found: dict[str, dict[str, Any]] = {}
    for column in columns:
        name = column.removeprefix(_PREFIX)
        if name in STEP_FIELDS and column in (SUBTASK, _PREFIX + name):
            names = _NAMES.get(name)
            shape = [len(names) if names else 1]
            found[column] = {"dtype": _DTYPES[STEP_FIELDS[name][0]], "shape": shape, "names": names}
    return found


# --- language ---

_ROW = {"role": pa.string(), "content": pa.string(), "style": pa.string()}
_TAIL = {"camera": pa.string(), "tool_calls": pa.list_(pa.string())}
_TYPES = {
    PERSISTENT: pa.list_(pa.struct({**_ROW, "timestamp": pa.float32(), **_TAIL})),
    EVENTS: pa.list_(pa.struct({**_ROW, **_TAIL})),
}


def language_features() -> dict[str, dict[str, Any]]:
    """Entries of info.json."""
    return {name: {"dtype": "language", "shape": [1], "names": None} for name in _TYPES}


def with_language(
    table: pa.Table, labels: Labels, instruction: str, question: str | None
) -> pa.Table:
    """The table of an episode with both columns; LeRobot itself describes them to `datasets`.

    question: the task's own, if it has one.
    """
    said = language_rows(labels, instruction, table.column("timestamp").to_numpy())
    values = pa.array(said, _TYPES[PERSISTENT].value_type)
    repeated = values.take(pa.array(np.tile(np.arange(len(said)), table.num_rows)))
    offsets = pa.array(np.arange(table.num_rows + 1, dtype=np.int32) * len(said))
    table = table.append_column(PERSISTENT, pa.ListArray.from_arrays(offsets, repeated))
    asked = pa.array(questions.rows(labels, question), _TYPES[EVENTS])
    return table.append_column(EVENTS, asked).replace_schema_metadata(None)


def language_rows(labels: Labels, instruction: str, timestamps: np.ndarray) -> list[dict[str, Any]]:
    """What is said in an episode, each row from its time on."""

    def row(role: str, style: str, content: str, step: int) -> dict[str, Any]:
        return {
            "role": role,
            "content": content,
            "style": style,
            "timestamp": float(timestamps[step]),
            "camera": None,
            "tool_calls": None,
        }

    wordings = dict.fromkeys([instruction, *labels.paraphrases])
    rows = [row("user", "task_aug", wording, 0) for wording in wordings]
    for style, texts in (
        ("subtask", labels.subtasks()),
        ("plan", labels.plans()),
        ("memory", labels.memories()),
    ):
        for step, text in enumerate(texts):
            if text and (step == 0 or text != texts[step - 1]):
                rows.append(row("assistant", style, text, step))
    return sorted(rows, key=lambda one: (one["timestamp"], one["style"], one["role"]))
