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
    "TaskFailedError",
    "UnavailableError",
    "UnknownIdError",
]


class Error(Exception):
    """Base of all exceptions that engram raises itself."""

    def __init__(self, *message: object) -> None:
        super().__init__(*(_one_line(str(part)) for part in message))


_LONGEST = 2000  # characters


def _one_line(message: str) -> str:
    """The message as one line that terminals can show, whatever values are in it."""
    line = " ".join(message.split())
    if len(line) > _LONGEST:
        line = line[: _LONGEST // 2] + " ... " + line[-_LONGEST // 2 :]
    if line.isprintable():
        return line
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in line)


class InvalidArgumentError(Error, ValueError):
    """A value outside what is allowed, or of the wrong type or shape."""


class UnknownIdError(Error, KeyError):
    """No task, option or field of that name."""

    __str__ = Exception.__str__  # KeyError would put the message in quotes


class UnavailableError(Error, RuntimeError):
    """The machine lacks a resource: threads, memory, a device."""


class BadStateError(Error, RuntimeError):
    """The call is not allowed at this point."""


class IoError(Error, OSError):
    """A file could not be read or written."""


class TaskFailedError(Error, RuntimeError):
    """The code of a user's task has failed where its own exception cannot come out."""


class InternalError(Error, RuntimeError):
    """A defect of engram itself."""
