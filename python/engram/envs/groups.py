"""Batches of several tasks: the tasks asked for, and what holds of each environment."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from engram._args.options import task_id
from engram._args.values import constants_json, integer, pin_list, real, text_keys
from engram.errors import InvalidArgumentError

# A task's share: id, environments, constants, pins and task options, as the extension takes them.
Share = tuple[str, int, str, list[tuple[str, list[float]]], list[tuple[str, float]]]

# Outputs of several tasks that never change.
CONSTANT = ("task_index", "object_mask")

_OWN = ("num_envs", "constants", "pins", "task_options")


def shares_of(tasks: Any, num_envs: Any) -> list[Share] | None:
    """The tasks of a batch of several; None for an id, which stands for one task.

    Args:
        tasks: An id; a list of ids, which share ``num_envs`` evenly, the first ones taking what is
            left over, and have one environment each where that is 1; or a dict from ids to numbers
            of environments or to dicts with "num_envs", "constants", "pins" and "task_options".
        num_envs: Of the whole batch.
    """
    if isinstance(tasks, Mapping):
        shares = [_share(id, value) for id, value in tasks.items()]
    elif isinstance(tasks, Sequence) and not isinstance(tasks, (str, bytes)):
        total = integer("num_envs", num_envs)
        count = len(tasks)
        if count and total != 1 and total < count:
            raise InvalidArgumentError(
                f"num_envs: {total} given for {count} tasks; 1, or {count} and more allowed"
            )
        each, left = (1, 0) if total == 1 or not count else divmod(total, count)
        shares = [_share(id, each + (i < left)) for i, id in enumerate(tasks)]
    else:
        return None
    if not shares:
        raise InvalidArgumentError(f"id: {tasks!r} given, at least one task needed")
    if isinstance(tasks, Mapping) and num_envs not in (1, sum(share[1] for share in shares)):
        raise InvalidArgumentError(
            f"num_envs: {num_envs!r} given beside the numbers of each task; leave it out"
        )
    return shares


def _share(id: Any, value: Any) -> Share:
    name = task_id(id)
    own: Mapping[str, Any] = value if isinstance(value, Mapping) else {"num_envs": value}
    for key in own:
        if key not in _OWN:
            raise InvalidArgumentError(
                f"{name}: {key!r} given; a task of several has: {', '.join(_OWN)}"
            )
    options = text_keys("task_options", own.get("task_options") or {})
    return (
        name,
        integer(f"num_envs of {name}", own.get("num_envs", 1), 1, 1_000_000),
        constants_json(own.get("constants")),
        pin_list("pins", own.get("pins") or {}),
        [(key, real(f"task_options: {key}", number)) for key, number in options.items()],
    )


class TaskGroup:
    """The tasks of a batch, in the order of their environments. A batch of one task is one too.

    Attributes:
        several: True for a batch made of a list or dict.
        tasks: Descriptions of the tasks.
        ids: Their ids.
        index: (N,) number of each environment's task.
        slots: (N,) place of each environment in its task.
        names: (N,) its id, as objects; None for a batch of one task.
    """

    def __init__(self, description: Any, num_envs: int) -> None:
        self.several = "tasks" in description
        self.tasks: list[Any] = description["tasks"] if self.several else [description]
        self.ids = tuple(str(task["id"]) for task in self.tasks)
        counts = [task["num_envs"] for task in self.tasks] if self.several else [num_envs]
        self.index = np.repeat(np.arange(len(counts), dtype=np.int32), counts)
        self.slots = np.concatenate([np.arange(count) for count in counts])
        self.names = np.array(self.ids, dtype=object)[self.index] if self.several else None
        self._outputs = description["outputs"]

    def of(self, index: int) -> Any:
        """Description of an environment's task."""
        return self.tasks[self.index[index]]

    def known(self) -> dict[str, np.ndarray]:
        """Masks (N,) of the environments whose tasks have an output, of those that not all have."""
        masks: dict[str, np.ndarray] = {}
        if not self.several:
            return masks
        cues = any(task["task_cue_dim"] for task in self.tasks)  # that policies may see
        owned = [
            {out["name"] for out in task["outputs"]}
            - ({"task_cue"} if cues and not task["task_cue_dim"] else set())
            for task in self.tasks
        ]
        for output in self._outputs:
            name = output["name"]
            has = [name in own for own in owned]
            if any(has) and not all(has):
                masks[name] = np.array(has)[self.index]
        return masks

    def split_reset(self, options: Any) -> Iterator[Any]:
        """Options of a reset, with those of single tasks handed to their environments.

        Pins and constants may be dicts by id. Yields options for parts of the batch.
        """
        by_task: dict[str, Any] = {}
        if self.several and isinstance(options, Mapping):
            names = ("pins", "constants")
            by_task = {name: options[name] for name in names if self._is_by_id(options.get(name))}
        if not by_task:
            yield options
            return
        mask = options.get("reset_mask")
        chosen = np.ones(len(self.index), np.bool_) if mask is None else np.asarray(mask)
        for number, id in enumerate(self.ids):
            part = chosen & (self.index == number)
            if part.any():
                own = {name: values[id] for name, values in by_task.items() if id in values}
                rest = {name: value for name, value in options.items() if name not in by_task}
                yield {**rest, **own, "reset_mask": part}

    def _is_by_id(self, values: Any) -> bool:
        if not isinstance(values, Mapping) or not values:
            return False
        if not all(isinstance(value, Mapping) for value in values.values()):
            return False
        for id in values:
            if id not in self.ids:
                raise InvalidArgumentError(
                    f"{id!r} given; tasks of this batch: {', '.join(self.ids)}"
                )
        return True


def joined(shares: Sequence[Share]) -> str:
    """The ids of several tasks as one."""
    return "+".join(share[0] for share in shares)
