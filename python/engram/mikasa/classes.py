"""The classes of tasks: a base per family and one per id, from engram's own list.

``__all__`` has those of the VLA half; those of the RL half are ``engram.mikasa.rl.memory_envs``.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from typing import Any

import gymnasium as gym

from engram.mikasa import _constructors, _docstrings, _families, _rl_families
from engram.mikasa._variants import TaskMeta
from engram.mikasa.env import BaseEnv
from engram.mikasa.registration import register_env
from engram.tasks import list_tasks
from engram.typing import TaskSummary

__all__: list[str] = []

_RL = "rl"  # the split


def _attributes(task: TaskSummary) -> dict[str, Any]:
    return {
        "__module__": __name__,
        "_generated": True,
        "_task": task["id"],
        "_family": task["family"],
        "_rl": task["split"] == _RL,
        "_set": {},
        "_own": (),
        "_changes": {},
    }


def _first_of(tasks: list[TaskSummary]) -> TaskSummary:
    """The shortest task of a family; the base class has its constants."""
    plain = [task for task in tasks if "-Long" not in task["id"]]
    return min(plain, key=lambda task: (task["horizon"], len(task["id"])))


def _warn_of_other_package(tasks: Iterable[TaskSummary]) -> None:
    """Warns if another package has registered ids of these tasks; they become engram's."""
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


def _families_of(split_is_rl: bool) -> dict[str, list[TaskSummary]]:
    """The original's tasks of one half, by family."""
    families: dict[str, list[TaskSummary]] = {}
    for task in list_tasks():
        of_half = task["split"] == _RL if split_is_rl else task["id"].endswith("-VLA-v0")
        if task["family"] in _families.LEAF_CONSTANTS and of_half:
            families.setdefault(task["family"], []).append(task)
    _warn_of_other_package(task for tasks in families.values() for task in tasks)
    return families


def _add(classes: dict[str, TaskMeta], name: str, base: Any, attributes: dict[str, Any]) -> Any:
    classes[name] = TaskMeta(name, (base,), attributes)
    return classes[name]


def _add_leaf(
    classes: dict[str, TaskMeta], name: str, base: Any, task: TaskSummary, own: tuple[str, ...]
) -> None:
    doc = _docstrings.of_class(task, f"{task['id']}: {task['instruction']}", own)
    leaf = _add(classes, name, base, {**_attributes(task), "_own": own, "__doc__": doc})
    register_env(task["id"], max_episode_steps=task["horizon"])(leaf)


def _make() -> dict[str, TaskMeta]:
    """The classes of the VLA half."""
    classes: dict[str, TaskMeta] = {}
    families = _families_of(split_is_rl=False)
    # The easy batteries are hard ones with another rule.
    for family in sorted(families, key=lambda name: name == "BatteriesCheckerEasy"):
        tasks = families[family]
        parent = classes.get(_families.base_name("BatteriesCheckerHard"))
        base = parent if family == "BatteriesCheckerEasy" and parent is not None else BaseEnv
        attributes = _attributes(_first_of(tasks))
        attributes["_changes"] = _families.BASE_CONSTANTS.get(family, {})
        first = _first_of(tasks)
        own = _families.LEAF_CONSTANTS[family]
        attributes["__doc__"] = _docstrings.of_class(first, f"All tasks of {family}.", own)
        attributes.update(_constructors.of_family(family, rl=False))
        root = _add(classes, _families.base_name(family), base, attributes)
        for task in tasks:
            name = _families.leaf_name(task["id"])
            _add_leaf(classes, name, root, task, own)
    return classes


def _make_rl() -> dict[str, TaskMeta]:
    """The classes of the RL half."""
    classes: dict[str, TaskMeta] = {}
    for family, tasks in _families_of(split_is_rl=True).items():
        root: Any = BaseEnv
        name = _rl_families.base_name(family)
        own = _rl_families.LEAF_CONSTANTS.get(family, ())
        if name is not None:
            first = _first_of(tasks)
            attributes = _attributes(first) | _constructors.of_family(family, rl=True)
            attributes["__doc__"] = _docstrings.of_class(first, f"All RL tasks of {family}.", own)
            root = _add(classes, name, BaseEnv, attributes)
        for task in tasks:
            _add_leaf(classes, _rl_families.leaf_name(task["id"]), root, task, own)
    return classes


CLASSES = _make()
RL_CLASSES = _make_rl()
globals().update(CLASSES)
globals().update(RL_CLASSES)
__all__ += list(CLASSES)
