"""Checks of the arguments of reset, step and other methods of batches."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from engram._args.values import constants_json, integer, nearest, pin_list, seed_value
from engram.errors import InvalidArgumentError, UnknownIdError

_FLOAT32 = np.dtype(np.float32)
_RESET_OPTIONS = ("reset_mask", "pins", "constants")


def kind_of(value: Any) -> str:
    """A value's type, for messages."""
    if isinstance(value, np.ndarray):
        return f"an array of {value.dtype}, shape {value.shape},"
    return type(value).__name__


def real_array(name: str, value: Any) -> np.ndarray:
    """Anything array-like as an array of real numbers, none of them masked."""
    if np.ma.is_masked(value):
        raise InvalidArgumentError(
            f"{name}: {kind_of(value)} given with masked values, none allowed"
        )
    try:
        array = np.asarray(value)
    except Exception as error:
        raise InvalidArgumentError(f"{name}: cannot be read as an array ({error})") from None
    if array.dtype.kind not in "fiu":
        raise InvalidArgumentError(f"{name}: dtype {array.dtype} given, real numbers needed")
    return array


def checked_actions(actions: Any, shape: tuple[int, ...]) -> np.ndarray:
    """Anything array-like as contiguous float32."""
    if (
        type(actions) is np.ndarray
        and actions.dtype is _FLOAT32
        and actions.shape == shape
        and actions.flags.carray
    ):
        return actions
    array = real_array("actions", actions)
    if array.shape != shape:
        raise InvalidArgumentError(f"actions: shape {array.shape} given, {shape} needed")
    with np.errstate(over="ignore"):  # step refuses infinite values
        return np.require(array, np.float32, ["C_CONTIGUOUS", "ALIGNED"])


def check_actions_out(out: Any, shape: tuple[int, ...]) -> None:
    """Refuses what actions cannot be written to as they are."""
    if not (
        isinstance(out, np.ndarray)
        and out.dtype == np.float32
        and out.shape == shape
        and out.flags.carray
    ):
        raise InvalidArgumentError(
            f"out: {kind_of(out)} given; a writable float32 array of shape "
            f"{shape} without gaps is needed"
        )


def reset_options(
    options: dict[str, Any] | None, num_envs: int
) -> tuple[np.ndarray | None, Any | None, str | None]:
    """Mask, pins and ranges of a reset; None where there are none."""
    if options is None:
        return None, None, None
    if not isinstance(options, Mapping):
        raise InvalidArgumentError(f"options: {kind_of(options)} given, a dict needed")
    for name in options:
        _refuse_misspelt(name)
    pins = options.get("pins")
    mask = _mask(options.get("reset_mask"), num_envs)
    constants = options.get("constants")
    return (
        mask,
        None if pins is None else pin_list("pins", pins),
        None if constants is None else constants_json(constants),
    )


def _refuse_misspelt(name: Any) -> None:
    """Refuses misspelt names of our options; all others are for wrappers, as in Gymnasium."""
    if not isinstance(name, str) or name in _RESET_OPTIONS:
        return
    meant = nearest(name, _RESET_OPTIONS)
    if meant is not None:
        raise UnknownIdError(
            f"reset option {name!r} given, did you mean {meant!r}? "
            f"engram's are: {', '.join(_RESET_OPTIONS)}"
        )


def _mask(mask: Any, num_envs: int) -> np.ndarray | None:
    """The mask of environments to reset."""
    if mask is None:
        return None
    if isinstance(mask, (list, tuple)) and all(isinstance(one, (bool, np.bool_)) for one in mask):
        mask = np.array(mask, np.bool_)
    if not isinstance(mask, np.ndarray) or mask.dtype != np.bool_:
        raise InvalidArgumentError(
            f"reset_mask: {kind_of(mask)} given, a bool array or a list of bools needed"
        )
    if mask.shape != (num_envs,):
        raise InvalidArgumentError(f"reset_mask: shape {mask.shape} given, ({num_envs},) needed")
    if not mask.any():
        raise InvalidArgumentError("reset_mask: True for no environment")
    return np.array(mask)  # the caller may change theirs


def seed_list(seed: Any, num_envs: int, slots: np.ndarray) -> np.ndarray | list[int | None] | None:
    """One unsigned 64-bit seed per environment; a list if some are None.

    Args:
        seed: A first seed for each task, or one for each environment.
        num_envs: Number of environments.
        slots: Place of each environment in its task.
    """
    if seed is None:
        return None
    if isinstance(seed, (list, tuple)) or (isinstance(seed, np.ndarray) and seed.ndim > 0):
        values = [None if value is None else seed_value("seed", value) for value in seed]
        if len(values) != num_envs:
            raise InvalidArgumentError(f"seed: {len(values)} values given, {num_envs} needed")
        return values if None in values else np.array(values, np.uint64)
    first = seed_value("seed", seed)
    return np.uint64(first) + slots.astype(np.uint64)  # beyond 2**64 it begins at 0


def batch_index(index: Any, num_envs: int) -> int:
    """The index of an environment; -1, which stands for the whole batch, for None."""
    if index is None:
        return -1
    number = integer("index", index)
    if not 0 <= number < num_envs:
        raise InvalidArgumentError(f"index: {number} given; allowed: 0 to {num_envs - 1}")
    return number
