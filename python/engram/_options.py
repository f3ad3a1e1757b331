"""From keyword arguments to the options of a batch."""

from __future__ import annotations

import operator
import secrets
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from engram import _core
from engram._compat import DEFAULT_AUTORESET, AutoresetMode
from engram.errors import InvalidArgumentError

OBS_MODES = {"none": 0, "state": 1, "state_dict": 2, "rgb": 3}
REWARD_MODES = {"none": 0, "sparse": 1, "dense": 2, "normalized_dense": 3}
AUTORESET_MODES = {
    AutoresetMode.NEXT_STEP: 0,
    AutoresetMode.SAME_STEP: 1,
    AutoresetMode.DISABLED: 2,
}
POLICIES = {"zero": 0, "random": 1, "oracle": 2, "blind": 3}


def one_of(name: str, value: Any, allowed: Mapping[str, int]) -> int:
    """The number behind a word."""
    if isinstance(value, str) and value in allowed:
        return allowed[value]
    raise InvalidArgumentError(f"{name}: {value!r} given; allowed: {', '.join(allowed)}")


def integer(name: str, value: Any, low: int = -(2**31), high: int = 2**31 - 1) -> int:
    """The value as an int that fits its place."""
    try:
        number = operator.index(value)
    except TypeError:
        raise InvalidArgumentError(f"{name}: {value!r} given, an integer needed") from None
    if not low <= number <= high:
        raise InvalidArgumentError(f"{name}: {number} given; allowed: {low} to {high}")
    return number


def seed_value(name: str, value: Any) -> int:
    """A seed: any unsigned 64-bit integer."""
    return integer(name, value, 0, 2**64 - 1)


def real(name: str, value: Any) -> float:
    """The value as a float."""
    try:
        return float(value)
    except (TypeError, ValueError):
        raise InvalidArgumentError(f"{name}: {value!r} given, a number needed") from None


def _text(name: str, value: Any) -> str:
    if not isinstance(value, str):
        raise InvalidArgumentError(f"{name}: {value!r} given, a string needed")
    return value


def _mapping(name: str, value: Any) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise InvalidArgumentError(
            f"{name}: {value!r} given; a dict from names to values is needed"
        )
    for key in value:
        _text(f"name in {name}", key)
    return value


def pin_list(name: str, pins: Any) -> list[tuple[str, list[float]]]:
    """Pins as the extension takes them; each value is a number or a sequence of numbers."""
    result = []
    for key, value in _mapping(name, pins).items():
        try:
            values = np.atleast_1d(np.asarray(value, dtype=np.float64))
        except (TypeError, ValueError):
            raise InvalidArgumentError(
                f"{name}: {key}={value!r} given, a number or a sequence of numbers needed"
            ) from None
        result.append((key, [float(number) for number in values.ravel()]))
    return result


def autoreset(value: Any) -> AutoresetMode:
    """The mode by member, or by name in Gymnasium's or the engram command's spelling."""
    if value is None:
        return DEFAULT_AUTORESET
    if isinstance(value, str):
        name = value.replace("-", "_").upper()
        names = {mode.value.upper(): mode for mode in AUTORESET_MODES}
        names.update({mode.name: mode for mode in AUTORESET_MODES}, OFF=AutoresetMode.DISABLED)
        if name in names:
            return names[name]
    elif isinstance(value, AutoresetMode):
        return value
    raise InvalidArgumentError(
        f"autoreset_mode: {value!r} given; allowed: "
        f"{', '.join(mode.name for mode in AUTORESET_MODES)}"
    )


def make_options(
    *,
    num_envs: Any,
    seed: Any,
    threads: Any,
    chunk: Any,
    substeps: Any,
    obs_mode: Any,
    reward_mode: Any,
    control_mode: Any,
    autoreset_mode: AutoresetMode,
    rotation_sign: Any,
    freeze_cue: Any,
    terminate_on_success: Any,
    sleep: Any,
    robot_init_qpos_noise: Any,
    pins: Any,
    task_options: Any,
    image_size: Any,
    cameras: Any,
    renderer: Any,
    shadows: Any,
    antialias: Any,
) -> _core.Options:
    """Options of a batch. Ranges are the library's to check; here they must merely fit."""
    options = _core.Options()
    options.num_envs = integer("num_envs", num_envs)
    options.seed = secrets.randbits(63) if seed is None else seed_value("seed", seed)
    options.threads = integer("threads", threads)
    options.chunk = integer("chunk", chunk)
    options.substeps = integer("substeps", substeps)
    options.obs_mode = one_of("obs_mode", obs_mode, OBS_MODES)
    options.reward_mode = one_of("reward_mode", reward_mode, REWARD_MODES)
    options.control_mode = _text("control_mode", control_mode)
    options.auto_reset = AUTORESET_MODES[autoreset_mode]
    options.rotation_sign = integer("rotation_sign", rotation_sign)
    options.freeze_cue = int(bool(freeze_cue))
    options.terminate_on_success = (
        -1 if terminate_on_success is None else int(bool(terminate_on_success))
    )
    options.sleep = int(bool(sleep))
    options.robot_init_qpos_noise = real("robot_init_qpos_noise", robot_init_qpos_noise)
    options.pins = pin_list("pins", {} if pins is None else pins)
    options.task_options = [
        (name, real(f"task_options: {name}", value))
        for name, value in _mapping("task_options", task_options or {}).items()
    ]
    width, height = size_pair(image_size)
    options.image_width, options.image_height = width, height
    if cameras is not None:
        if isinstance(cameras, str) or not isinstance(cameras, Sequence):
            raise InvalidArgumentError(f"cameras: {cameras!r} given, a list of names needed")
        options.cameras = [_text("cameras", camera) for camera in cameras]
    options.renderer = _text("renderer", renderer)
    options.shadows = int(bool(shadows))
    options.antialias = int(bool(antialias))
    return options


def size_pair(value: Any) -> tuple[int, int]:
    """A side, or a pair of width and height, in pixels."""
    if isinstance(value, (tuple, list)) and len(value) == 2:
        return integer("image width", value[0]), integer("image height", value[1])
    side = integer("image_size", value)
    return side, side
