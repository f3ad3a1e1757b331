"""Labels of demonstrations: the truth in words, keyframes, objects and answers (docs/datasets.md).

All but the paraphrases are privileged: they tell what a policy has to find out.
"""

from __future__ import annotations

import dataclasses
import zipfile
from typing import Any

import numpy as np

from engram.datasets import checks
from engram.datasets.checks import DatasetError
from engram.datasets.npz_arrays import ANY, read_array

# Arrays with a row per step: type, sizes of a row. The last three: of tasks with answers only.
STEP_FIELDS: dict[str, tuple[type, tuple[int, ...]]] = {
    "subtask_index": (np.int32, ()),
    "is_keyframe": (np.bool_, ()),
    "progress": (np.float32, ()),
    "object_index": (np.int32, ()),
    "object_box": (np.int32, (2, 4)),
    "object_point": (np.int32, (2, 3)),
    "answered": (np.bool_, ()),
    "first_answer": (np.int32, ()),
    "first_answer_correct": (np.bool_, ()),
}
_ANSWERS = ("answered", "first_answer", "first_answer_correct")
_TEXTS = ("plan", "memory", "object_names", "paraphrases")
_NUMBERS = ("plan_step", "plan_index", "memory_step")  # of the texts


@dataclasses.dataclass(frozen=True)
class Labels:
    """Labels of one episode; docs/datasets.md tells what each array holds."""

    steps: dict[str, np.ndarray]  # of STEP_FIELDS, without answers in tasks that have none
    plan: list[str]
    plan_step: np.ndarray
    plan_index: np.ndarray
    memory: list[str]
    memory_step: np.ndarray
    object_names: list[str]
    paraphrases: list[str]

    def __post_init__(self) -> None:
        for name in _TEXTS:
            for text in getattr(self, name):
                checks.instruction(name, text)
        for name in _NUMBERS:
            texts, numbers = getattr(self, name.split("_")[0]), getattr(self, name)
            if len(texts) != len(numbers):
                raise DatasetError(f"{name}: {len(numbers)} numbers of {len(texts)} texts")
        _check_begins("plan_step", self.plan_step, len(self))
        _check_begins("memory_step", self.memory_step, len(self))
        if not self.plan or self.plan_step[0] != 0:
            raise DatasetError("plan: nothing holds at the first step")
        highest = self.steps["object_index"].max(initial=-1)
        if highest >= len(self.object_names) or self.steps["object_index"].min(initial=0) < -1:
            raise DatasetError(f"object_index: {highest}, of {len(self.object_names)} objects")
        checks.finite("progress", self.steps["progress"])
        self.subtasks()  # which must all be in the plan

    def __len__(self) -> int:
        return len(self.steps["subtask_index"])

    def subtasks(self) -> list[str]:
        """Per step: words of the subtask that is to be done."""
        return [self._plan_at(step)[index] for step, index in self._indices()]

    def plans(self) -> list[str]:
        """Per step: a numbered list of what is left to do."""
        texts = []
        for step, index in self._indices():
            left = [words for i, words in sorted(self._plan_at(step).items()) if i >= index]
            texts.append("\n".join(f"{i}. {words}" for i, words in enumerate(left, 1)))
        return texts

    def memories(self) -> list[str]:
        """Per step: what has been shown and has to be remembered; "" before that."""
        shown = np.searchsorted(self.memory_step, np.arange(len(self)), side="right")
        texts = ["", *self.memory]
        return [texts[number] for number in shown]

    def objects(self) -> list[str]:
        """Per step: the object that the subtask is about; "" for none."""
        names = [*self.object_names, ""]
        return [names[index] for index in self.steps["object_index"]]

    def step_texts(self) -> dict[str, list[str]]:
        """What is said at every step."""
        return {
            "subtask": self.subtasks(),
            "plan": self.plans(),
            "memory": self.memories(),
            "object": self.objects(),
        }

    def _indices(self) -> list[tuple[int, int]]:
        return list(enumerate(self.steps["subtask_index"].tolist()))

    def _plan_at(self, step: int) -> dict[int, str]:
        """Words of subtasks by index, as the plan is at a step."""
        begin = self.plan_step[np.searchsorted(self.plan_step, step, side="right") - 1]
        chosen = np.flatnonzero(self.plan_step == begin)
        plan = {int(self.plan_index[i]): self.plan[i] for i in chosen}
        index = int(self.steps["subtask_index"][step])
        if index not in plan:
            raise DatasetError(
                f"subtask_index: {index} in step {step}; in the plan: {sorted(plan)}"
            )
        return plan


def load(archive: zipfile.ZipFile, steps: int) -> Labels:
    """Labels of a file, whose episode has `steps` steps."""
    names = set(archive.namelist())
    values: dict[str, Any] = {
        name: read_array(archive, name, kind, (steps, *row))
        for name, (kind, row) in STEP_FIELDS.items()
        if name not in _ANSWERS or f"{name}.npy" in names
    }
    texts = {name: read_array(archive, name, None, (ANY,)).tolist() for name in _TEXTS}
    numbers: dict[str, Any] = {
        name: read_array(archive, name, np.int32, (ANY,)) for name in _NUMBERS
    }
    return Labels(values, **texts, **numbers)


def _check_begins(what: str, begins: np.ndarray, steps: int) -> None:
    if (np.diff(begins) < 0).any() or (begins < 0).any() or (begins >= steps).any():
        raise DatasetError(
            f"{what}: {checks.short(begins.tolist())} given; steps from 0 to {steps - 1} needed, "
            "in order"
        )
