"""Reads the documents of `engram eval`, with their checksums (protocol/evaluation writes them)."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from engram.datasets import checks
from engram.datasets.checks import DatasetError

_LARGEST = 64 << 20  # bytes
_SPACE = re.compile(rb'("(?:[^"\\\\]|\\\\.)*")|[ \t\r\n]+')
_CHECKSUM = re.compile(rb'(.*),"checksum":"([0-9a-f]{16})"\}', re.DOTALL)


def read_result(path: Path, with_checksum: bool = False) -> dict[str, Any]:
    """The document of a file. with_checksum: it must have one; one that is there must be right.

    Raises DatasetError.
    """
    with checks.reading(path):
        if not path.is_file():  # opening a pipe would wait for its other end
            raise DatasetError("missing, or no file")
        if path.stat().st_size > _LARGEST:
            raise DatasetError(f"more than {_LARGEST >> 20} MB")
        text = path.read_bytes()
        document = json.loads(text)
        if not isinstance(document, dict):
            raise DatasetError("an object needed")
        if with_checksum or "checksum" in document:
            _check(text)
        return document


def _check(text: bytes) -> None:
    """The checksum at the end is that of the line before it, without spaces."""
    line = _SPACE.sub(lambda found: found[1] or b"", text)
    found = _CHECKSUM.fullmatch(line)
    if found is None or f"{_fnv1a(found[1] + b'}'):016x}" != found[2].decode():
        raise DatasetError("it was changed after it was written: its checksum is another one")


def _fnv1a(data: bytes) -> int:
    value = 0xCBF29CE484222325
    for byte in data:
        value = (value ^ byte) * 0x100000001B3 & 0xFFFFFFFFFFFFFFFF
    return value
