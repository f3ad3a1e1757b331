"""Checks of single values, told by the name of the argument."""

from __future__ import annotations

import json
import operator
from collections.abc import Mapping
from typing import Any

from engram.errors import InvalidArgumentError


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


def constants_json(constants: Mapping[str, Any] | None) -> str:
    """Constants of a task, by name, as JSON; what each may be is the library's to check."""
    if constants is None:
        return ""
    if not isinstance(constants, Mapping):
        raise InvalidArgumentError(
            f"constants: {constants!r} given; a dict from names to values is needed"
        )
    for key in constants:
        text("name in constants", key)
    try:
        return json.dumps({key: _plain(value) for key, value in constants.items()})
    except (TypeError, ValueError):
        raise InvalidArgumentError(
            f"constants: {dict(constants)!r} given; numbers, texts and lists of them allowed"
        ) from None


def _plain(value: Any) -> Any:
    """The value without NumPy's types, which have a method for that."""
    if hasattr(value, "tolist"):
        return value.tolist()
    return [_plain(one) for one in value] if isinstance(value, (list, tuple)) else value


def text(name: str, value: Any) -> str:
    """The value, which must be a string."""
    if not isinstance(value, str):
        raise InvalidArgumentError(f"{name}: {value!r} given, a string needed")
    return value
