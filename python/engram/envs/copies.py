"""Two ways to return the arrays of a batch: as copies, or as views of its buffers."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

from engram import _core

# Bytes from which on the allocator gets fresh pages from the system every time.
_LARGE = 1 << 17


class Copier:
    """Makes, for nested dicts of arrays, functions that return copies of them.

    Memory of large copies is used again once no array refers to it any more.
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


def same(value: Any) -> Callable[[], Any]:
    """Makes a function that returns the value itself."""
    return lambda: value
