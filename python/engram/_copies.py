"""How a batch hands out its arrays: as copies or as they are."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

from engram import _core

# Memory of this size comes fresh from the system, page by page, unless it is used again.
_LARGE = 1 << 17


class Copied:
    """Called with nested dicts of arrays, returns what makes copies of them.

    Memory of large copies is used again once nobody holds them any more, nor anything that was
    made of them.
    """

    def __init__(self) -> None:
        self._large = _core.Copies()

    def __call__(self, value: Any) -> Callable[[], Any]:
        if isinstance(value, dict):
            parts = {key: self(part) for key, part in value.items()}
            return lambda: {key: part() for key, part in parts.items()}
        if value.nbytes < _LARGE or not value.flags.c_contiguous:
            copy: Callable[[], Any] = value.copy
            return copy
        return functools.partial(self._large.copy, value)


def as_it_is(value: Any) -> Callable[[], Any]:
    """Returns what hands out the value itself."""
    return lambda: value
