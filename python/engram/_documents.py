"""JSON documents that end with a checksum, as those of the engram command do."""

from __future__ import annotations

import json
import re
from typing import Any

__all__ = ["DamagedError", "check", "checksum_of", "to_text"]

_KEY = "checksum"
_STRING_OR_SPACE = re.compile(r'("(?:[^"\\]|\\.)*")|\s+')
_END = re.compile(rf',"{_KEY}":"([0-9a-f]{{16}})"\}}\Z')


class DamagedError(ValueError):
    """A document's checksum does not fit."""


def checksum_of(line: str) -> str:
    """The checksum of a document without one, as JSON without spaces (core/base/checksum.h)."""
    value = 0xCBF29CE484222325
    for byte in line.encode():
        value = (value ^ byte) * 0x100000001B3 & 0xFFFFFFFFFFFFFFFF
    return f"{value:016x}"


def to_text(document: dict[str, Any]) -> str:
    """The document as JSON, with its checksum in place of an old one."""
    rest = {key: value for key, value in document.items() if key != _KEY}
    line = json.dumps(rest, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    return json.dumps({**rest, _KEY: checksum_of(line)}, indent=2, ensure_ascii=False) + "\n"


def check(text: str) -> None:
    """Refuses the text of an object without its checksum.

    Raises:
        DamagedError: It was changed since the engram command wrote it.
    """
    line = _STRING_OR_SPACE.sub(r"\1", text)
    end = _END.search(line)
    if end is None:
        raise DamagedError("no checksum at its end: it was edited")
    if checksum_of(line[: end.start()] + "}") != end[1]:
        raise DamagedError("its checksum does not fit: it was edited")
