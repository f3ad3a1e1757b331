"""Questions about the past of an episode, with answers, as LeRobot's rows of style "vqa".

Each is asked at or after the frame that showed its answer, and says which one that was.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from engram.datasets.labels import Labels
from engram.datasets.lerobot import layout
from engram.datasets.spaces import CONTROL_RATE

_SHOWN = "What has been shown so far that is to be remembered?"


def question_of(env_id: str) -> str | None:
    """The task's own question; None without one, or of a task that is registered elsewhere."""
    import engram
    from engram.tasks import describe

    try:
        choices = describe(env_id)["choices"]
    except engram.Error:
        return None
    return choices["question"] if choices else None


def rows(labels: Labels, question: str | None) -> list[list[dict[str, Any]]]:
    """Rows of each frame: at those that show something, at keyframes, and once a second."""
    memories = labels.memories()
    asked = labels.steps["is_keyframe"] | (np.arange(len(labels)) % CONTROL_RATE == 0)
    found: list[list[dict[str, Any]]] = []
    since = 0
    for step, memory in enumerate(memories):
        is_new = step == 0 or memory != memories[step - 1]
        since = step if is_new else since
        if not memory or not (is_new or asked[step]):
            found.append([])
            continue
        # What the task asks for is known when nothing more is shown.
        known = question is not None and memory == memories[-1]
        found.append(_pair(question if known and question else _SHOWN, memory, since))
    return found


def _pair(question: str, answer: str, since: int) -> list[dict[str, Any]]:
    document = {"label": "past", "attribute": "shown", "value": answer, "since_frame": since}
    usual = {"style": "vqa", "camera": layout.TOP, "tool_calls": None}
    return [
        {"role": "user", "content": question, **usual},
        {"role": "assistant", "content": json.dumps(document), **usual},
    ]
