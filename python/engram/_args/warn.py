"""Warnings that name the caller's line."""

from __future__ import annotations

import sys
import warnings

_LIBRARIES = ("engram", "gymnasium")


def warn(text: str) -> None:
    """Warns of the innermost frame outside this package and Gymnasium."""
    frame = sys._getframe(1)
    level = 2
    while frame.f_back is not None and _is_library(frame.f_globals.get("__name__", "")):
        frame = frame.f_back
        level += 1
    warnings.warn(text, UserWarning, stacklevel=level)


def _is_library(module: str) -> bool:
    return module.partition(".")[0] in _LIBRARIES
