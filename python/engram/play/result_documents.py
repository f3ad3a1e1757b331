"""Reads the documents of `engram eval`, with their checksums (protocol/evaluation writes them)."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from engram import _documents
from engram.datasets import checks
from engram.datasets.checks import DatasetError

_LARGEST = 64 << 20  # bytes


def read_result(path: Path) -> dict[str, Any]:
    """The document of a file, whose checksum must be right. Raises DatasetError."""
    with checks.reading(path):
        if not path.is_file():  # opening a pipe would wait for its other end
            raise DatasetError("missing, or no file")
        if path.stat().st_size > _LARGEST:
            raise DatasetError(f"more than {_LARGEST >> 20} MB")
        text = path.read_bytes().decode()
        document = json.loads(text)
        if not isinstance(document, dict):
            raise DatasetError("an object needed")
        _documents.check(text)
        return document
