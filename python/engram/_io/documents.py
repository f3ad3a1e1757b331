"""JSON documents that end with a checksum, as those of the engram command do."""

from __future__ import annotations

import hashlib
import json
import re
from typing import Any

__all__ = ["DamagedError", "check", "checksum_of", "parse", "to_text", "with_checksum"]

_KEY = "checksum"
_DIGITS = 16
_STRING_OR_SPACE = re.compile(r'("(?:[^"\\]|\\.)*")|\s+')
_END = re.compile(rf',"{_KEY}":"([0-9a-f]{{{_DIGITS}}})"\}}\Z')


class DamagedError(ValueError):
    """A document is no JSON object, or its checksum does not fit."""


def checksum_of(line: str) -> str:
    """The checksum of a document without one, as JSON without spaces and line breaks."""
    return hashlib.sha256(line.encode()).hexdigest()[:_DIGITS]


def with_checksum(text: str) -> str:
    """The JSON text of an object, which is not empty, with its checksum as the last member."""
    body = text.rstrip()[:-1].rstrip()
    return f'{body},\n  "{_KEY}": "{checksum_of(_line(body) + "}")}"\n}}\n'


def to_text(document: dict[str, Any]) -> str:
    """The document as JSON, with its checksum in place of an old one."""
    rest = {key: value for key, value in document.items() if key != _KEY}
    return with_checksum(json.dumps(rest, indent=2, ensure_ascii=False, allow_nan=False))


def _line(text: str) -> str:
    """JSON without spaces and line breaks; numbers stay as they are written."""
    return _STRING_OR_SPACE.sub(r"\1", text)


def check(text: str) -> None:
    """Refuses the text of an object without its checksum.

    Raises:
        DamagedError: It was changed since `to_text` or the engram command wrote it.
    """
    line = _line(text)
    end = _END.search(line)
    if end is None:
        raise DamagedError("no checksum at its end: it was edited")
    if checksum_of(line[: end.start()] + "}") != end[1]:
        raise DamagedError("its checksum does not fit: it was edited")


def parse(text: str) -> dict[str, Any]:
    """Reads what `to_text` or the engram command wrote.

    Raises:
        DamagedError: It is something else, or was changed since.
    """
    document = json.loads(text)
    if not isinstance(document, dict):
        raise DamagedError("an object needed")
    check(text)
    return document
