"""Inputs of one policy for several tasks."""

import contextlib

import torch
from policy import TOKEN, ObservationLayout

import engram

# Ten tasks that a student of one task alone learns within minutes. `distil.py --id ten`.
TEN = (
    "RememberColor3-VLA-v0",
    "RememberColor5-VLA-v0",
    "RememberColor9-VLA-v0",
    "RememberShape3-VLA-v0",
    "RememberShape5-VLA-v0",
    "FindImposterColor3-VLA-v0",
    "FindImposterShape3-VLA-v0",
    "ShellGameTouch-VLA-v0",
    "InterceptSlow-VLA-v0",
    "TakeItBack-VLA-v0",
)


class TaskInputs:
    """Makes inputs: the robot, the task as one-hot, then the objects in the common layout.

    Built from the description of a batch of several tasks, with objects observations.
    """

    def __init__(self, description):
        tasks, fields = description["tasks"], description["state_fields"]
        self.ids = [task["id"] for task in tasks]
        self.layout = ObservationLayout(description, tasks=len(tasks))
        self.robot = sum(f["width"] for f in fields if not f["name"].startswith(TOKEN))
        self.width = description["state_dim"]
        common = {field["name"]: field["offset"] for field in fields}
        self.columns = {task["id"]: common_columns(task, common) for task in tasks}

    @classmethod
    def of(cls, ids):
        with contextlib.closing(engram.make_vec(list(ids), obs_mode="objects", threads=1)) as batch:
            return cls(batch.description)

    def of_batch(self, rows, index):
        """Inputs from rows (N, width) in the common layout, and the number of each one's task."""
        task = torch.nn.functional.one_hot(index.long(), len(self.ids)).to(rows.dtype)
        return torch.cat([rows[:, : self.robot], task, rows[:, self.robot :]], -1)

    def of_task(self, id, rows):
        """Inputs from rows of one task alone, in its own layout."""
        if id not in self.columns:
            raise ValueError(f"{id} given; tasks of this policy: {', '.join(self.ids)}")
        columns = self.columns[id]
        if rows.shape[1] != len(columns):
            given = f"{rows.shape[1]} numbers given, {len(columns)} needed"
            raise ValueError(f"{given}: obs objects of {id}")
        common = rows.new_zeros(len(rows), self.width)
        common[:, columns] = rows
        return self.of_batch(common, torch.full((len(rows),), self.ids.index(id)))


def common_columns(task, common):
    """Columns of the common layout, in the order of a task's own row."""
    fields = sorted(task["state_fields"], key=lambda field: field["offset"])
    return [common[f["name"]] + i for f in fields for i in range(f["width"])]
