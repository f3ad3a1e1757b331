"""Inputs of one policy for several tasks."""

import contextlib

import torch

import engram
from engram_learners.images.detector import robot_numbers
from engram_learners.instructions import BagOfWords, vocabulary
from engram_learners.layout import TOKEN, ObservationLayout

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


def short_split():
    """The ids of the benchmark's short split. `distil.py --id short`."""
    tasks = engram.list()
    return tuple(t["id"] for t in tasks if t["split"] == "short" and t["canonical"])


SETS = {"ten": lambda: TEN, "short": short_split}  # names of --id
# Conditioning on the task, by name: words, numbered of `TaskInputs.of`.
TASK_INPUTS = {"number": (None, True), "words": (True, False), "both": (True, True)}


class TaskInputs:
    """Makes inputs: the robot, the task, then the objects in the common layout.

    The task is a one-hot of its number, a bag of words of its instruction, or both.
    Built from the description of a batch of several tasks, with objects observations.

    Args:
        words: the vocabulary, or None: no instruction
        numbered: whether there is the one-hot
        options: of the environment, from env_options.py
    """

    def __init__(self, description, words=None, numbered=True, options=None):
        tasks, fields = description["tasks"], description["state_fields"]
        self.ids = [task["id"] for task in tasks]
        self.bag_of_words, self.numbered = BagOfWords(words or ()), numbered
        self.options = options or {}
        self.last = None, None  # sentences and their bags
        count = len(tasks) if numbered else 0
        self.layout = ObservationLayout(description, count, self.bag_of_words.words)
        self.robot = sum(f["width"] for f in fields if not f["name"].startswith(TOKEN))
        self.width = description["state_dim"]
        self.common = {field["name"]: field["offset"] for field in fields}
        self.columns = {task["id"]: common_columns(task, self.common) for task in tasks}

    @classmethod
    def of(cls, ids, words=None, numbered=True, options=None):
        """words: a vocabulary, True: that of the instructions of these tasks, or None."""
        batch = engram.make_vec(list(ids), obs_mode="objects", threads=1, **(options or {}))
        with contextlib.closing(batch):
            words = vocabulary(batch.description["tasks"]) if words is True else words
            return cls(batch.description, words, numbered, options)

    @classmethod
    def like(cls, ids, layout, options=None):
        """The inputs that a policy of this layout was trained with."""
        return cls.of(ids, layout.words, layout.tasks > 0, options)

    def of_batch(self, rows, index, sentences=(), robot=None):
        """Inputs from rows (N, width) in the common layout.

        index (N,): number of each one's task; sentences: instruction of each, if there are words.
        robot: numbers of the robot, if not those of the objects observation.
        """
        robot = self.robot if robot is None else robot
        parts = [rows[:, :robot]]
        if self.numbered:
            one_hot = torch.nn.functional.one_hot(index.long(), len(self.ids))
            parts.append(one_hot.to(rows.dtype))
        if self.bag_of_words.words:
            parts.append(self.bags(sentences))
        return torch.cat([*parts, rows[:, robot:]], -1)

    def bags(self, sentences):
        if sentences is not self.last[0]:  # once per episode, not per step
            self.last = sentences, self.bag_of_words(sentences)
        return self.last[1]

    def of_task(self, id, rows, sentences=()):
        """Inputs from rows of one task alone, in its own layout.

        With instructions alone, a task need not be one of training.
        """
        columns = self.columns_of(id)
        if rows.shape[1] != len(columns):
            given = f"{rows.shape[1]} numbers given, {len(columns)} needed"
            raise ValueError(f"{given}: obs objects of {id}")
        common = rows.new_zeros(len(rows), self.width)
        common[:, columns] = rows
        return self.of_batch(common, self.numbers_of(id, len(rows)), sentences)

    def of_images(self, id, rows, sentences=()):
        """Inputs from rows of one task alone, of a detector: their layout is the common one."""
        robot = robot_numbers(self.layout)
        return self.of_batch(rows, self.numbers_of(id, len(rows)), sentences, robot)

    def numbers_of(self, id, count):
        """The task's number, that many times; 0 where the number is no input."""
        if self.numbered and id not in self.ids:
            raise ValueError(f"{id} given; tasks of this policy: {', '.join(self.ids)}")
        return torch.full((count,), self.ids.index(id) if self.numbered else 0)

    def columns_of(self, id):
        if id not in self.columns:
            self.numbers_of(id, 0)  # refuses tasks that the policy does not know
            task = engram.describe(id, obs_mode="objects", **self.options)
            unknown = [f["name"] for f in task["state_fields"] if f["name"] not in self.common]
            if unknown:
                most = f"{self.layout.tokens} objects at most, as in training"
                raise ValueError(f"{id} has {unknown[0]}; {most}")
            self.columns[id] = common_columns(task, self.common)
        return self.columns[id]


def common_columns(task, common):
    """Columns of the common layout, in the order of a task's own row."""
    fields = sorted(task["state_fields"], key=lambda field: field["offset"])
    return [common[f["name"]] + i for f in fields for i in range(f["width"])]
