"""Constants of classes: read, set on a class, changed in subclasses."""

from __future__ import annotations

import copy
import difflib
import functools
from collections.abc import Iterator, Mapping
from typing import Any

import gymnasium as gym

from engram.errors import InvalidArgumentError, UnknownIdError
from engram.mikasa import _families, _forms, _rl_families
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
# Texts of a task; that of Rotate has a number of the episode in it.
_INSTRUCTION = "LANGUAGE_INSTRUCTION"
_TEMPLATE = "LANGUAGE_INSTRUCTION_TEMPLATE"
# Class attributes in capitals that are no constants of a task.
_OTHERS = (
    "SUPPORTED_ROBOTS",
    "SUPPORTED_REWARD_MODES",
    "SUPPORTED_OBS_MODES",
    _INSTRUCTION,
    _TEMPLATE,
)
_SAME = 0.85  # similarity from which on a name counts as misspelt


class TaskMeta(type(gym.Env)):  # type: ignore[misc]
    """Metaclass of tasks: constants are class attributes.

    The classes of this package read theirs from engram on use. What is set on them is kept in
    ``_set``; it holds for what is made afterwards. ``_own`` names the constants that a class has
    values of its own for, in the original.
    """

    def __getattr__(cls, name: str) -> Any:
        """A constant of the task."""
        if name.isupper() and _has_task(cls):
            if name in (_INSTRUCTION, _TEMPLATE):
                return _instruction(cls, name)
            return _constant(cls, name)
        raise _missing(cls, name)

    def __setattr__(cls, name: str, value: Any) -> None:
        """Sets a constant of a class of this package, or any other attribute.

        Raises:
            UnknownIdError: The task has no such constant; the message names the nearest one.
            InvalidArgumentError: The constant is fixed, or the instruction is no text.
        """
        if not (name.isupper() and _is_generated(cls)) or name.startswith("SUPPORTED_"):
            super().__setattr__(name, value)
            return
        _check_set(cls, name, value)
        cls._set[name] = value

    def __delattr__(cls, name: str) -> None:
        """Takes back what was set on a class of this package."""
        if name in cls.__dict__.get("_set", {}):
            del cls._set[name]
        else:
            super().__delattr__(name)

    def __dir__(cls) -> list[str]:
        names = set(super().__dir__())
        if _has_task(cls):
            names |= {*task_constants(cls._task), *_texts(cls)}
        return sorted(names)


def _missing(cls: type, name: str) -> AttributeError:
    return AttributeError(f"type object {cls.__name__!r} has no attribute {name!r}")


def _has_task(cls: type) -> bool:
    return any("_task" in vars(one) for one in cls.__mro__)


def _is_generated(cls: type) -> bool:
    return bool(cls.__dict__.get("_generated", False))


def _generated_of(cls: type) -> Iterator[Any]:
    """The classes of this package that a class has, the nearest first."""
    return (one for one in cls.__mro__ if _is_generated(one))


@functools.cache
def _described(task: str) -> Any:
    return describe(task, rules="original")


@functools.cache
def task_constants(task: str) -> Mapping[str, Any]:
    """Constants of a task, in the original's forms."""
    return _forms.of_task(_described(task)["constants"], _described(task)["family"])


def _phases(cls: Any) -> Mapping[str, str]:
    """Names of constants: engram's by the original's, where the RL half has others."""
    return _rl_families.PHASES.get(cls._family, {}) if cls._rl else {}


def _usual(cls: Any) -> dict[str, Any]:
    """Constants of a class that nobody has set."""
    return {**task_constants(cls._task), **_forms.of_task(cls._changes)}


def _changeable(cls: Any) -> list[str]:
    names = [constant["name"] for constant in _described(cls._task)["changeable"]]
    return [*names, *_phases(cls)]


def _constant(cls: Any, name: str) -> Any:
    usual = _usual(cls)
    home: Any = None  # the class that has the value
    for one in _generated_of(cls):
        if one._family == cls._family:
            home = one
        if name in one._set:
            return one._set[name]
        if name in one._own:
            break
    if name not in usual:
        raise _missing(cls, name)
    # Lists and arrays belong to the class from now on: what users write into them counts, too.
    value = copy.deepcopy(usual[name])
    if not isinstance(value, (int, float, str)):
        home._set[name] = value
    return value


def _texts(cls: Any) -> tuple[str, ...]:
    """Names of a class's texts. The RL half has none."""
    if cls._rl:
        return ()
    return (_INSTRUCTION, _TEMPLATE) if cls._family in _families.ROTATE else (_INSTRUCTION,)


def _instruction(cls: Any, name: str) -> str:
    """The instruction; that of TimedTransfer names the delay. The RL half has none."""
    if cls._rl:
        raise _missing(cls, name)
    own = own_instruction(cls)
    if own is not None:
        return own
    known: str = _described(cls._task)["instruction"]
    if name == _TEMPLATE and "{" not in known:
        raise _missing(cls, name)
    constants = changed_constants(cls) if cls._family == "TimedTransfer" else {}
    if constants:
        known = describe(cls._task, rules="original", constants=constants)["instruction"]
    return known


def _check_set(cls: Any, name: str, value: Any) -> None:
    if name in _texts(cls):
        if not isinstance(value, str):
            raise InvalidArgumentError(f"{cls.__name__}.{name}: {value!r} given, a text needed")
        return
    usual = _usual(cls)
    if name not in usual and name not in _changeable(cls):
        nearest = difflib.get_close_matches(name, [*usual, *_texts(cls)], n=1, cutoff=0)[0]
        raise UnknownIdError(
            f"{cls.__name__}.{name} set; the task has no such constant, did you mean {nearest}?"
        )
    if name not in _changeable(cls) and not _forms.same(value, usual[name]):
        raise _fixed(cls, name, value)


def _fixed(cls: Any, name: str, value: Any) -> InvalidArgumentError:
    return InvalidArgumentError(
        f"{cls.__name__}.{name}: {value!r} given; engram has it fixed at {_usual(cls)[name]!r}; "
        f"changeable: {', '.join(_changeable(cls))}"
    )


def _nearest_values(cls: type, names: tuple[str, ...] | None) -> dict[str, Any]:
    """Values in capitals that users gave a class or its bases: these names; None: constants."""
    given: dict[str, Any] = {}
    hidden: set[str] = set()  # those that a nearer class of this package has its own values for
    for one in cls.__mro__:
        if not isinstance(one, TaskMeta):
            continue
        values = one._set if _is_generated(one) else vars(one)
        for name, value in values.items():
            wanted = name.isupper() and name not in _OTHERS if names is None else name in names
            if wanted and name not in given and name not in hidden:
                given[name] = value
        hidden |= set(one.__dict__.get("_own", ()))
    return given


def own_constants(cls: type) -> dict[str, Any]:
    """Copies of the constants that users gave the class or its bases."""
    return copy.deepcopy(_nearest_values(cls, None))


def own_instruction(cls: type) -> str | None:
    """The instruction that users gave the class or its bases, if they did."""
    given: str | None = next(iter(_nearest_values(cls, (_TEMPLATE, _INSTRUCTION)).values()), None)
    return given


def changed_constants(cls: Any) -> dict[str, Any]:
    """Constants that a class changes, as ``engram.make_vec`` takes them.

    Raises:
        InvalidArgumentError: The class overrides a method of the core, or a fixed constant, or
            gives one constant by two names.
        UnknownIdError: A name is nearly a constant's.
    """
    check_methods(cls)
    given = _nearest_values(cls, None)
    for name, other in _phases(cls).items():
        if name in given and other in given:
            raise InvalidArgumentError(
                f"{cls.__name__}: {name}={given[name]!r} and {other}={given[other]!r} given, which "
                "are one constant; allowed: one of the two names"
            )
    wanted = {**cls._changes, **given}
    if not wanted:
        return {}
    changeable = _changeable(cls)
    usual = task_constants(cls._task)
    result = {}
    for name, value in wanted.items():
        if name in usual and _forms.same(value, usual[name]):
            continue
        if name in changeable:
            result[_phases(cls).get(name, name)] = value
        elif name in usual:
            raise _fixed(cls, name, value)
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
        if not isinstance(one, TaskMeta) or _is_generated(one):
            continue
        for name, why in _REFUSED_METHODS.items():
            if name in vars(one):
                raise InvalidArgumentError(
                    f"{one.__name__}.{name} is overridden, which has no effect in engram: {why}; "
                    "allowed: step, evaluate, compute_dense_reward, "
                    "compute_normalized_dense_reward, compute_sparse_reward, constants"
                )
