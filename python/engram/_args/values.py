"""Checks of single values; errors start with the name of the argument."""

from __future__ import annotations

import difflib
import json
import operator
import os
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from engram.errors import InvalidArgumentError


def one_of(name: str, value: Any, allowed: Mapping[str, int]) -> int:
    """The number behind a word."""
    if isinstance(value, str) and value in allowed:
        return allowed[value]
    raise InvalidArgumentError(f"{name}: {value!r} given; allowed: {', '.join(allowed)}")


def nearest(name: str, names: Iterable[str]) -> str | None:
    """The closest of the names, for messages; None if none is close."""
    names = list(names)
    parts = [one for one in names if len(name) > 2 and (name in one or one in name)]
    near = difflib.get_close_matches(name.lower(), names, n=1, cutoff=0.7) or parts
    return near[0] if near else None


def integer(name: str, value: Any, low: int = -(2**31), high: int = 2**31 - 1) -> int:
    """The value as an int that fits its place."""
    try:
        number = operator.index(_no_boolean(value))
    except TypeError:
        raise InvalidArgumentError(f"{name}: {value!r} given, an integer needed") from None
    if not low <= number <= high:
        raise InvalidArgumentError(f"{name}: {number} given; allowed: {low} to {high}")
    return number


def seed_value(name: str, value: Any) -> int:
    """A seed: any unsigned 64-bit integer."""
    return integer(name, value, 0, 2**64 - 1)


def worker_seed(base: int, worker: int) -> int:
    """The first seed of a batch in one of many workers, processes or runs.

    Batches of different pairs play different episodes: environment i has this number plus i, and
    the numbers are far apart. It is ``SeedSequence([base, worker]).generate_state(1, uint64)`` of
    NumPy, without its lowest bit and shifted by it, so that it stays below 2**63.

    Args:
        base: The run's seed, unsigned 64 bit.
        worker: Number of the worker, unsigned 64 bit.

    Raises:
        InvalidArgumentError: One of them is no integer, or out of range.
    """
    pair = [seed_value("base", base), seed_value("worker", worker)]
    return int(np.random.SeedSequence(pair).generate_state(1, np.uint64)[0]) >> 1


def real(name: str, value: Any) -> float:
    """The value as a float."""
    try:
        if not isinstance(value, (str, bytes, bytearray)):
            return float(_no_boolean(value))
    except (TypeError, ValueError, OverflowError):
        pass
    raise InvalidArgumentError(f"{name}: {value!r} given, a number needed")


def _no_boolean(value: Any) -> Any:
    """The value, unless it is one that Python takes for 0 or 1."""
    if isinstance(value, (bool, np.bool_)):
        raise TypeError
    return value


def boolean(name: str, value: Any) -> bool:
    """The value, which must be True or False: what merely counts as one may mean the other."""
    if not isinstance(value, (bool, np.bool_)):
        raise InvalidArgumentError(f"{name}: {value!r} given; allowed: True, False")
    return bool(value)


def constants_json(constants: Mapping[str, Any] | None) -> str:
    """Constants of a task, by name, as JSON; what each may be is the library's to check."""
    if constants is None:
        return ""
    text_keys("constants", constants)
    try:
        return json.dumps({key: _plain(value) for key, value in constants.items()})
    except (TypeError, ValueError, RecursionError):
        raise InvalidArgumentError(
            f"constants: {dict(constants)!r} given; numbers, texts and lists of them allowed"
        ) from None


def _plain(value: Any) -> Any:
    """The value without types of NumPy and torch; single precision as the number that it shows."""
    if isinstance(value, np.float32):
        return float(str(value))
    if hasattr(value, "tolist"):
        array = np.asarray(value)
        return value.tolist() if array.dtype != np.float32 else [_plain(one) for one in array]
    if isinstance(value, Mapping):
        return {str(key): _plain(one) for key, one in value.items()}
    return [_plain(one) for one in value] if isinstance(value, (list, tuple)) else value


def text_keys(name: str, value: Any) -> Mapping[str, Any]:
    """The value, which must be a dict with names for keys."""
    if not isinstance(value, Mapping):
        raise InvalidArgumentError(
            f"{name}: {value!r} given; a dict from names to values is needed"
        )
    for key in value:
        text(f"name in {name}", key)
    return value


def levels(what: str, given: Any) -> list[tuple[str, float]]:
    """Axes of perturbations and their levels; None: none."""
    given = {} if given is None else given
    return [
        (axis, real(f"{what}: {axis}", level)) for axis, level in text_keys(what, given).items()
    ]


def pin_list(name: str, pins: Any) -> list[tuple[str, list[float]]]:
    """Pins as the extension takes them; each value is a number or a sequence of numbers."""
    result = []
    for key, value in text_keys(name, pins).items():
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


def text(name: str, value: Any) -> str:
    """The value, which must be a string that C can hold."""
    if not isinstance(value, str):
        raise InvalidArgumentError(f"{name}: {value!r} given, a string needed")
    if "\0" in value or any("\ud800" <= letter <= "\udfff" for letter in value):
        raise InvalidArgumentError(
            f"{name}: {value!r} given, a string without character 0 and surrogates needed"
        )
    return value


def path(name: str, value: Any) -> str:
    """The value, which must be the name of a file or folder."""
    try:
        given = os.fsdecode(value)
    except (TypeError, ValueError):
        raise InvalidArgumentError(f"{name}: {value!r} given, a path needed") from None
    if not given:
        raise InvalidArgumentError(f"{name}: '' given, a path needed")
    return text(name, given)
