"""Reads documents of `engram eval`, with their checksums (protocol/eval/results writes them)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from engram._io import documents
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
        return documents.parse(path.read_bytes().decode())
