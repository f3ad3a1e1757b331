"""Checks of external data, before it is used."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any

import numpy as np

MAX_EPISODES = 1_000_000
MAX_STEPS = 20_000  # of an episode; its images take up 2 GB then
MAX_SEED = 2**63 - 1
MAX_FPS = 1000
MAX_JOBS = 1024
CAMERA_SHAPE = (128, 128, 3)
IMAGE_SHAPE = (128, 128, 6)  # base camera, wrist camera
_LONGEST_TEXT = 10_000
_LONGEST_MESSAGE = 600
_ID = re.compile(r"[A-Za-z0-9._-]+-v[0-9]+")
_LONGEST_ID = 100


class DatasetError(Exception):
    """A data set is missing, incomplete or damaged; the message names it and the reason.

    The message is one line that terminals can show, whatever names and values are in it.
    """

    def __init__(self, message: str):
        super().__init__(printable(message))


def printable(text: str) -> str:
    """A foreign text as one line of bounded length, without control characters."""
    line = " ".join(text[: 2 * _LONGEST_MESSAGE].split())
    shown = "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in line)
    long = len(shown) > _LONGEST_MESSAGE or len(text) > 2 * _LONGEST_MESSAGE
    return shown[:_LONGEST_MESSAGE] + "..." if long else shown


@contextlib.contextmanager
def reading(path: Path | str | IO[bytes]) -> Iterator[None]:
    """Turns exceptions of readers of external files into a DatasetError with the path.

    Parsers of archives, images, tables and messages raise errors of all kinds over damaged input,
    those of their own defects among them.
    """
    try:
        yield
    except ModuleNotFoundError:
        raise
    except DatasetError as error:
        raise DatasetError(f"'{path}': {error}") from error
    except Exception as error:
        reason = str(error) or type(error).__name__
        if isinstance(error, KeyError):
            reason += " is missing"
        raise DatasetError(f"'{path}' is damaged, or not engram's: {reason}") from error


def regular_file(path: Path, most: int | None = None) -> Path:
    """The path, which must lead to a regular file of at most `most` bytes.

    Opening a pipe would wait for its other end, which may never come.
    """
    if not path.is_file():
        raise DatasetError("missing, or no file")
    if most is not None and path.stat().st_size > most:
        raise DatasetError(f"more than {most >> 20} MB")
    return path


def whole_number(what: str, value: Any, low: int, high: int) -> int:
    """The value, which must be an int from low to high."""
    if type(value) is not int or not low <= value <= high:
        raise DatasetError(
            f"{what}: {short(value)} given; a whole number from {low} to {high} needed"
        )
    return value


def env_id(what: str, value: Any) -> str:
    """The value, which must have the form that ids have: then it can be a folder's name."""
    if not isinstance(value, str) or len(value) > _LONGEST_ID or not _ID.fullmatch(value):
        raise DatasetError(
            f"{what}: {short(value)} given; an id needed: letters, digits and '-_.' that end in -v "
            f"and a number, at most {_LONGEST_ID}"
        )
    return value


def instruction(what: str, value: Any) -> str:
    """The value, which must be a text that files can hold."""
    if not isinstance(value, str) or not 1 <= len(value) <= _LONGEST_TEXT:
        raise DatasetError(
            f"{what}: {short(value)} given; a text of 1 to {_LONGEST_TEXT} characters needed"
        )
    if not value.isprintable():
        raise DatasetError(
            f"{what}: {short(value)} given; a text without control characters needed"
        )
    return value


def within_one(what: str, values: np.ndarray) -> None:
    """The values, which must be from -1 to 1."""
    largest = np.abs(values).max(initial=0)
    if largest > 1:
        raise DatasetError(f"{what}: {largest} given; numbers in [-1, 1] needed")


def finite(what: str, values: np.ndarray) -> None:
    """The values, which must be numbers."""
    good = np.isfinite(values)
    if not good.all():
        step = int(np.argwhere(~good)[0][0])
        raise DatasetError(f"{what}: a value that is not finite in step {step}; numbers needed")


def short(value: Any) -> str:
    """A value for messages."""
    try:
        text = repr(value)
    except Exception:  # a number of more digits than Python prints, a list that holds itself
        return f"a value of type {type(value).__name__}"
    return text if len(text) <= 100 else text[:100] + "..."
