"""The classes of tasks: a base per family and one per id, from engram's own list."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from typing import Any

import gymnasium as gym

from engram.mikasa import _families
from engram.mikasa._variants import TaskMeta
from engram.mikasa.env import BaseEnv
from engram.mikasa.registration import register_env
from engram.tasks import list_tasks
from engram.typing import TaskSummary

__all__: list[str] = []


def _attributes(task: TaskSummary) -> dict[str, Any]:
    return {
        "__module__": __name__,
        "_generated": True,
        "_task": task["id"],
        "_family": task["family"],
        "_set": {},
        "_own": (),
    }


def _first_of(tasks: list[TaskSummary]) -> TaskSummary:
    """The shortest task of a family; the base class has its constants."""
    plain = [task for task in tasks if "-Long" not in task["id"]]
    return min(plain, key=lambda task: (task["horizon"], len(task["id"])))


def _warn_of_other_package(tasks: Iterable[TaskSummary]) -> None:
    """Warns if somebody else has registered ids of these tasks; they become engram's."""
    taken = [task["id"] for task in tasks if task["id"] in gym.registry]
    if taken:
        entry: Any = gym.registry[taken[0]].entry_point
        entry = getattr(entry, "func", entry)
        maker = entry if isinstance(entry, str) else getattr(entry, "__module__", "unknown")
        warnings.warn(
            f"{len(taken)} ids, such as {taken[0]}, were registered by {maker}; from now on "
            "gym.make makes engram's environments of them",
            RuntimeWarning,
            stacklevel=2,
        )


def _make() -> dict[str, TaskMeta]:
    classes: dict[str, TaskMeta] = {}
    families: dict[str, list[TaskSummary]] = {}
    for task in list_tasks():
        if task["family"] in _families.INFO_KEYS and task["id"].endswith("-VLA-v0"):
            families.setdefault(task["family"], []).append(task)
    _warn_of_other_package(task for tasks in families.values() for task in tasks)
    # The easy batteries are hard ones with another rule.
    for family in sorted(families, key=lambda name: name == "BatteriesCheckerEasy"):
        tasks = families[family]
        parent = classes.get(_families.base_name("BatteriesCheckerHard"))
        base = parent if family == "BatteriesCheckerEasy" and parent is not None else BaseEnv
        attributes = _attributes(_first_of(tasks))
        attributes["_changes"] = _families.BASE_CONSTANTS.get(family, {})
        attributes["__doc__"] = f"Base of the classes of {family}."
        root = TaskMeta(_families.base_name(family), (base,), attributes)
        classes[root.__name__] = root
        for task in tasks:
            attributes = {**_attributes(task), "_changes": {}, "__doc__": f"{task['id']}."}
            attributes["_own"] = _families.LEAF_CONSTANTS[family]
            leaf = TaskMeta(_families.leaf_name(task["id"]), (root,), attributes)
            classes[leaf.__name__] = leaf
            register_env(task["id"], max_episode_steps=task["horizon"])(leaf)
    return classes


CLASSES = _make()
globals().update(CLASSES)
__all__ += list(CLASSES)
