"""Constants of classes, and their changes in subclasses."""

from __future__ import annotations

import difflib
import functools
from collections.abc import Mapping
from typing import Any

import gymnasium as gym
import numpy as np

from engram.errors import InvalidArgumentError, UnknownIdError
from engram.tasks import describe

# Methods that the original lets subclasses override and engram does not.
_REFUSED_METHODS = {
    "_get_obs_extra": "the core makes observations; change them in a wrapper",
    "_get_obs_agent": "the core makes observations; change them in a wrapper",
    "_initialize_episode": "the core draws episodes; fix draws with reset(options={'pins': ...})",
    "_load_scene": "the core builds the scene",
    "_load_agent": "the core builds the robot",
    "_load_lighting": "the core builds the scene",
    "_after_reconfigure": "scenes are not rebuilt",
    "_before_control_step": "the core runs the physics",
    "_after_control_step": "the core runs the physics",
    "_before_simulation_step": "the core runs the physics",
    "_after_simulation_step": "the core runs the physics",
    "_default_sensor_configs": "cameras stay where they are; their size is the keyword "
    "sensor_configs={'width': ..., 'height': ...}",
    "_default_human_render_camera_configs": "the camera stays where it is; its size is the keyword "
    "human_render_camera_configs={'width': ..., 'height': ...}",
    "_default_sim_config": "engram's physics has no such settings",
}
# Class attributes in capitals that are no constants of a task.
_OTHERS = (
    "SUPPORTED_ROBOTS",
    "SUPPORTED_REWARD_MODES",
    "SUPPORTED_OBS_MODES",
    "LANGUAGE_INSTRUCTION",
    "LANGUAGE_INSTRUCTION_TEMPLATE",
)
_SAME = 0.85  # similarity from which on a name counts as misspelt


class TaskMeta(type(gym.Env)):  # type: ignore[misc]
    """Metaclass of tasks: constants are class attributes, read from engram on use."""

    def __getattr__(cls, name: str) -> Any:
        """A constant of the task."""
        if name.isupper() and _has_task(cls):
            constants = {**task_constants(cls._task), **cls._changes}
            if name in constants:
                return constants[name]
        raise AttributeError(f"type object {cls.__name__!r} has no attribute {name!r}")

    def __dir__(cls) -> list[str]:
        names = set(super().__dir__())
        return sorted(names | set(task_constants(cls._task)) if _has_task(cls) else names)


def _has_task(cls: type) -> bool:
    return any("_task" in vars(one) for one in cls.__mro__)


@functools.cache
def _described(task: str) -> Any:
    return describe(task, rules="original")


@functools.cache
def task_constants(task: str) -> Mapping[str, Any]:
    """Constants of a task, in the original's forms."""
    constants = _described(task)["constants"]
    return {name: _plain(name, value) for name, value in constants.items()}


def _plain(name: str, value: Any) -> Any:
    if isinstance(value, dict):  # JSON has texts for keys
        value = {int(key): one for key, one in value.items()}
        if name == "COLOR_PALETTE":
            return {key: np.array(rgba) for key, rgba in value.items()}
    return value


def own_constants(cls: type) -> dict[str, Any]:
    """Constants of the user's classes, by name."""
    given: dict[str, Any] = {}
    for one in reversed(cls.__mro__):
        if isinstance(one, TaskMeta) and not one.__dict__.get("_generated", False):
            given.update({k: v for k, v in vars(one).items() if k.isupper() and k not in _OTHERS})
    return given


def own_instruction(cls: type) -> str | None:
    """The instruction that the user's classes give, if they do."""
    for one in cls.__mro__:
        if "LANGUAGE_INSTRUCTION" in vars(one):
            generated = vars(one).get("_generated", False)
            return None if generated else vars(one)["LANGUAGE_INSTRUCTION"]
    return None


def changed_constants(cls: Any) -> dict[str, Any]:
    """Constants that a class changes, as ``engram.make_vec`` takes them.

    Raises:
        InvalidArgumentError: The class overrides a method of the core, or a fixed constant.
        UnknownIdError: A name is nearly a constant's.
    """
    check_methods(cls)
    wanted = {**cls._changes, **own_constants(cls)}
    if not wanted:
        return {}
    description = _described(cls._task)
    changeable = {constant["name"]: constant for constant in description["changeable"]}
    usual = task_constants(cls._task)
    result = {}
    for name, value in wanted.items():
        if name in usual and _same(value, usual[name]):
            continue
        if name in changeable:
            result[name] = _given(value, changeable[name])
        elif name in usual:
            raise InvalidArgumentError(
                f"{cls.__name__}.{name}: {value!r} given; engram has it fixed at {usual[name]!r}; "
                f"changeable: {', '.join(changeable)}"
            )
        else:
            _refuse_misspelt(cls, name, [*usual, *changeable])
    return result


def _refuse_misspelt(cls: type, name: str, names: list[str]) -> None:
    meant = difflib.get_close_matches(name, names, n=1, cutoff=_SAME)
    if meant:
        raise UnknownIdError(f"{cls.__name__}.{name} given, did you mean {meant[0]}?")


def check_methods(cls: type) -> None:
    """Refuses classes that override methods of engram's core."""
    for one in cls.__mro__:
        if not isinstance(one, TaskMeta) or one.__dict__.get("_generated", False):
            continue
        for name, why in _REFUSED_METHODS.items():
            if name in vars(one):
                raise InvalidArgumentError(
                    f"{one.__name__}.{name} is overridden, which has no effect in engram: {why}; "
                    "allowed: step, evaluate, compute_dense_reward, "
                    "compute_normalized_dense_reward, compute_sparse_reward, constants"
                )


def _listed(value: Any) -> Any:
    if isinstance(value, Mapping):
        return [_listed(one) for one in value.values()]
    if hasattr(value, "tolist"):
        return value.tolist()
    return [_listed(one) for one in value] if isinstance(value, (list, tuple)) else value


def _same(one: Any, other: Any) -> bool:
    return bool(_listed(one) == _listed(other))


def _given(value: Any, constant: Mapping[str, Any]) -> Any:
    """A value in engram's form: names where the original has numbers or colours."""
    value = _listed(value)
    names = constant.get("names")
    if not names or not isinstance(value, list):
        return value
    if all(isinstance(one, int) for one in value):
        return [names[one] if 0 <= one < len(names) else one for one in value]
    colors = [
        _listed(color[1])
        for color in _described("RememberColor9-VLA-v0")["constants"]["COLOR_MAPPING"].values()
    ]
    return [_color(one, colors, names) if isinstance(one, list) else one for one in value]


def _color(rgba: list[float], colors: list[list[float]], names: list[str]) -> Any:
    for name, color in zip(names, colors):
        if np.allclose(np.array(color) / 255, rgba, atol=1e-3):
            return name
    return rgba
