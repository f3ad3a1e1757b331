"""Conversion of keyword arguments to the options of a batch."""

from __future__ import annotations

import json
import secrets
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from engram import _core
from engram._args.option_list import (
    AFTER_END,
    AUTO_RESET,
    CAMERAS,
    EVALUATION,
    IMAGE_SIDE,
    KINDS,
)
from engram._args.values import (
    boolean,
    constants_json,
    integer,
    levels,
    one_of,
    path,
    pin_list,
    real,
    seed_value,
    text,
    worker_seed,
)
from engram._ids import NAMESPACE
from engram.errors import InvalidArgumentError, UnknownIdError

# Cameras of rgb observations unless others are chosen.
SENSORS = ("base_camera", "hand_camera")

# Keywords of Python alone.
_PYTHON_ONLY = ("copy", "language_in_info", "privileged")


def _batch_seed(name: str, value: Any) -> int:
    if value is None:
        return secrets.randbits(63)
    if not isinstance(value, (tuple, list)):
        return seed_value(name, value)
    if len(value) != 2:
        raise InvalidArgumentError(f"{name}: {value!r} given; a pair is (base, worker)")
    return worker_seed(*value)


_CONVERTERS: dict[str, Callable[[str, Any], Any]] = {
    "bool": boolean,
    "maybe": lambda name, value: -1 if value is None else int(boolean(name, value)),
    "int": integer,
    "seed": _batch_seed,
    "real": real,
    "text": text,
    "maybe_text": lambda name, value: None if value is None else text(name, value),
    "seed_value": seed_value,
    "path": lambda name, value: None if value is None else path(name, value),
    "latency": lambda name, value: value if isinstance(value, str) else str(integer(name, value)),
}


def task_id(id: Any) -> str:
    """The id without Gymnasium's namespace."""
    return text("id", id).removeprefix(NAMESPACE)


def max_episode_steps(steps: Any) -> int:
    """Control steps until truncation, as the library takes them: 0 for the task's own horizon."""
    if steps is None:
        return 0
    steps = integer("max_episode_steps", steps)
    if steps < 1:
        raise InvalidArgumentError(
            f"max_episode_steps: {steps} given, 1 to 1000000 control steps or None allowed"
        )
    return int(steps)


def render_mode(value: Any, allowed: Sequence[str]) -> str | None:
    """The mode, if it is one of these, or None."""
    if value is not None and not (isinstance(value, str) and value in allowed):
        raise InvalidArgumentError(
            f"render_mode: {value!r} given; allowed: {', '.join(allowed)}, None"
        )
    return None if value is None else str(value)


def view(camera: Any, size: Any) -> tuple[str, int, int]:
    """Camera, width and height of views for people."""
    if not isinstance(camera, str) or camera not in CAMERAS:
        raise UnknownIdError(f"render_camera: {camera!r} given; allowed: {', '.join(CAMERAS)}")
    width, height = size_pair(size)
    low, high = IMAGE_SIDE
    if not (low <= width <= high and low <= height <= high):
        raise InvalidArgumentError(
            f"render_size: {size!r} given; allowed: {low} to {high} pixels on each side"
        )
    return camera, width, height


def make_options(arguments: Mapping[str, Any], auto_reset: str) -> _core.Options:
    """Options of a batch from the keywords of ``VectorEnv``.

    Types are checked here, ranges by the library.

    Args:
        arguments: The keywords.
        auto_reset: A name in AUTO_RESET; it replaces the keyword autoreset_mode.
    """
    options = _core.Options()
    for name, kind in KINDS.items():
        value = _converted(name, kind, arguments[name])
        if value is not None:
            setattr(options, name, value)
    for name in _PYTHON_ONLY:
        boolean(name, arguments.get(name, False))
    options.after_end = one_of("after_end", arguments["after_end"], AFTER_END)
    options.max_episode_steps = max_episode_steps(arguments["max_episode_steps"])
    options.auto_reset = AUTO_RESET[auto_reset]
    pins = arguments["pins"]
    options.pins = pin_list("pins", {} if pins is None else pins)
    options.task_options = levels("task_options", arguments["task_options"])
    options.perturbations = levels("perturb", arguments["perturb"])
    options.constants = constants_json(arguments["constants"])
    options.image_width, options.image_height = size_pair(arguments["image_size"])
    cameras = arguments["cameras"]
    if cameras is not None:
        if isinstance(cameras, str) or not isinstance(cameras, Sequence) or not cameras:
            raise InvalidArgumentError(f"cameras: {cameras!r} given, a list of names needed")
        options.cameras = [text("cameras", camera) for camera in cameras]
    return options


def make_evaluation_options(
    ids: list[str], arguments: Mapping[str, Any]
) -> _core.EvaluationOptions:
    """Options of an evaluation from the keywords of ``evaluate`` or ``probe``."""
    options = _core.EvaluationOptions()
    options.ids = ids
    for keyword, (name, kind) in EVALUATION.items():
        value = _converted(keyword, kind, arguments[keyword]) if keyword in arguments else None
        if value is not None:
            setattr(options, name, value)
    options.config_json = _config_json(arguments["config"])
    constants = constants_json(arguments["constants"])
    if constants:
        options.constants = constants
    options.task_options = levels("task_options", arguments["task_options"])
    options.perturbations = levels("perturb", arguments["perturb"])
    return options


def _config_json(config: Any) -> str:
    if config is not None and not isinstance(config, Mapping):
        raise InvalidArgumentError(f"config: {config!r} given, a dict needed")
    try:
        return json.dumps(dict(config or {}), allow_nan=False)
    except (TypeError, ValueError, RecursionError):
        raise InvalidArgumentError(f"config: {config!r} given, what JSON can hold needed") from None


def _converted(name: str, kind: str | Mapping[str, int], value: Any) -> Any:
    if isinstance(kind, str):
        return _CONVERTERS[kind](name, value)
    return one_of(name, value, kind)


def size_pair(value: Any) -> tuple[int, int]:
    """A side, or a pair of width and height, in pixels."""
    if isinstance(value, (tuple, list)) and len(value) == 2:
        return integer("image width", value[0]), integer("image height", value[1])
    side = integer("image_size", value)
    return side, side
