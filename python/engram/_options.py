"""From keyword arguments to the options of a batch."""

from __future__ import annotations

import secrets
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from engram import _core
from engram._compat import DEFAULT_AUTORESET, AutoresetMode
from engram._option_list import AFTER_END, AUTO_RESET, CAMERAS, IMAGE_SIDE, KINDS
from engram._values import boolean, constants_json, integer, one_of, real, seed_value, text
from engram.errors import InvalidArgumentError, UnknownIdError
from engram.registry import NAMESPACE

_AUTORESET_NAMES = {
    AutoresetMode.NEXT_STEP: "next-step",
    AutoresetMode.SAME_STEP: "same-step",
    AutoresetMode.DISABLED: "off",
}


# Cameras of rgb observations unless others are chosen.
SENSORS = ("base_camera", "hand_camera")

# Keywords that the library does not know.
_PYTHONS_OWN = ("copy", "language_in_info", "privileged")


def mapping(name: str, value: Any) -> Mapping[str, Any]:
    """The value, which must be a dict with names."""
    if not isinstance(value, Mapping):
        raise InvalidArgumentError(
            f"{name}: {value!r} given; a dict from names to values is needed"
        )
    for key in value:
        text(f"name in {name}", key)
    return value


def _random_or_seed(name: str, value: Any) -> int:
    return secrets.randbits(63) if value is None else seed_value(name, value)


_CONVERTERS: dict[str, Callable[[str, Any], Any]] = {
    "bool": boolean,
    "maybe": lambda name, value: -1 if value is None else int(boolean(name, value)),
    "int": integer,
    "seed": _random_or_seed,
    "real": real,
    "text": text,
}


def pin_list(name: str, pins: Any) -> list[tuple[str, list[float]]]:
    """Pins as the extension takes them; each value is a number or a sequence of numbers."""
    result = []
    for key, value in mapping(name, pins).items():
        try:
            values = np.atleast_1d(np.asarray(value))
        except (TypeError, ValueError):
            values = np.empty((0, 0))
        if values.dtype.kind not in "iuf" or values.ndim > 1:
            raise InvalidArgumentError(
                f"{name}: {key}={value!r} given, a number or a sequence of numbers needed"
            )
        result.append((key, [float(number) for number in values]))
    return result


def autoreset(value: Any) -> AutoresetMode:
    """The mode by member, or by name in Gymnasium's or the engram command's spelling."""
    if value is None:
        return DEFAULT_AUTORESET
    if isinstance(value, str):
        name = value.replace("-", "_").upper()
        names = {mode.value.upper(): mode for mode in _AUTORESET_NAMES}
        names.update({mode.name: mode for mode in _AUTORESET_NAMES}, OFF=AutoresetMode.DISABLED)
        if name in names:
            return names[name]
    elif isinstance(value, AutoresetMode):
        return value
    raise InvalidArgumentError(
        f"autoreset_mode: {value!r} given; allowed: "
        f"{', '.join(mode.name for mode in _AUTORESET_NAMES)}"
    )


def task_id(id: Any) -> str:
    """The id without Gymnasium's namespace."""
    return text("id", id).removeprefix(NAMESPACE)


def time_limit(steps: Any) -> int:
    """When episodes are truncated, as the library takes it: 0 for the task's own horizon."""
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


def picture(camera: Any, size: Any) -> tuple[str, int, int]:
    """Camera, width and height of pictures for people."""
    if not isinstance(camera, str) or camera not in CAMERAS:
        raise UnknownIdError(f"render_camera: {camera!r} given; allowed: {', '.join(CAMERAS)}")
    width, height = size_pair(size)
    low, high = IMAGE_SIDE
    if not (low <= width <= high and low <= height <= high):
        raise InvalidArgumentError(
            f"render_size: {size!r} given; allowed: {low} to {high} pixels on each side"
        )
    return camera, width, height


def make_options(arguments: Mapping[str, Any], autoreset_mode: AutoresetMode) -> _core.Options:
    """Options of a batch from the keywords of ``VectorEnv``.

    Ranges are the library's to check; here values must merely fit.
    """
    options = _core.Options()
    for name, kind in KINDS.items():
        setattr(options, name, _converted(name, kind, arguments[name]))
    for name in _PYTHONS_OWN:
        boolean(name, arguments.get(name, False))
    options.after_end = one_of("after_end", arguments["after_end"], AFTER_END)
    options.max_episode_steps = time_limit(arguments["max_episode_steps"])
    options.auto_reset = AUTO_RESET[_AUTORESET_NAMES[autoreset_mode]]
    pins = arguments["pins"]
    options.pins = pin_list("pins", {} if pins is None else pins)
    chosen = arguments["task_options"]
    options.task_options = [
        (name, real(f"task_options: {name}", value))
        for name, value in mapping("task_options", {} if chosen is None else chosen).items()
    ]
    options.constants = constants_json(arguments["constants"])
    options.image_width, options.image_height = size_pair(arguments["image_size"])
    cameras = arguments["cameras"]
    if cameras is not None:
        if isinstance(cameras, str) or not isinstance(cameras, Sequence) or not cameras:
            raise InvalidArgumentError(f"cameras: {cameras!r} given, a list of names needed")
        options.cameras = [text("cameras", camera) for camera in cameras]
    return options


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
