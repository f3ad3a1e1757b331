"""Exceptions: one base class, and one class per kind of failure.

Every message is one line and says what was wrong, what was given and what is allowed. A call that
raises has changed nothing.
"""

from __future__ import annotations

__all__ = [
    "BadStateError",
    "Error",
    "InternalError",
    "InvalidArgumentError",
    "IoError",
    "UnavailableError",
    "UnknownIdError",
]


class Error(Exception):
    """Base of all exceptions that engram raises itself."""


class InvalidArgumentError(Error, ValueError):
    """A value outside what is allowed, or of the wrong type or shape."""


class UnknownIdError(Error, KeyError):
    """No task, option or field of that name."""

    __str__ = Exception.__str__  # KeyError would put the message in quotes


class UnavailableError(Error, RuntimeError):
    """The machine lacks what was asked for: threads, memory, a device."""


class BadStateError(Error, RuntimeError):
    """The call is not allowed at this point."""


class IoError(Error, OSError):
    """A file could not be read or written."""


class InternalError(Error, RuntimeError):
    """A defect of engram itself."""
