"""How a converted folder was written: for engram's own readers, for people, and for resuming."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Collection
from pathlib import Path
from typing import Any

import engram
from engram._io import documents
from engram.datasets import checks, folders
from engram.datasets.additions import ADDITIONS, chosen
from engram.datasets.checks import DatasetError, reading
from engram.datasets.collected import CollectedEpisodes, EpisodeSource

NAME = "engram.json"
_LARGEST = 256 << 20  # bytes
_BLOCK = 1 << 20  # bytes that are read at a time
_CARD = "README.md"  # which owners of a data set edit


def document(folder: EpisodeSource, options: dict[str, Any]) -> dict[str, Any]:
    """The content of the file; options: those of the format."""
    return {
        "version": engram.__version__,
        "env_id": folder.env_id,
        **dataclasses.asdict(folder.spaces),
        "options": options,
        "collect": getattr(folder, "words", None),  # of episodes that came without NPZ
    }


def with_additions(folder: EpisodeSource, added: Collection[str]) -> dict[str, Any]:
    """A source of a format whose options are the additions."""
    return document(folder, {name: name in added for name in ADDITIONS})


def is_written(path: Path, folder: CollectedEpisodes, **options: bool) -> bool:
    """True if a format whose options are the additions is there, from the same collection.

    Refuses another one.
    """
    return is_same(path, NAME, with_additions(folder, chosen(**options)))


def write_json(path: Path, content: dict[str, Any]) -> None:
    """Writes a document of a converted folder."""
    path.write_text(json.dumps(content, indent=2) + "\n", "utf-8")


def write(path: Path, content: dict[str, Any], name: str = NAME) -> None:
    """Writes the document of a folder that is complete, with a SHA-256 of each file."""
    files = sorted(file for file in path.rglob("*") if file.is_file())
    sums = {str(file.relative_to(path)): _checksum(file) for file in files}
    listed = {file: sums[file] for file in sums if file not in (name, _CARD, folders.LIST)}
    (path / name).write_text(documents.to_text(content | {"files": listed}), "utf-8")


def verify(path: Path, name: str = NAME) -> dict[str, Any]:
    """The document of a folder; refuses one whose files are not as they were written."""
    document = _read(path / name)
    for file, checksum in document["files"].items():
        with reading(path / file):
            if _checksum(checks.regular_file(path / file)) != checksum:
                raise DatasetError("changed since it was written")
    return document


def _read(file: Path) -> dict[str, Any]:
    with reading(file):
        document = documents.parse(checks.regular_file(file, _LARGEST).read_text("utf-8"))
        for name in document["files"]:
            if Path(name).is_absolute() or ".." in Path(name).parts:
                raise DatasetError(f"files: {checks.short(name)} given; files of the folder needed")
        return document


def _checksum(file: Path) -> str:
    found = hashlib.sha256()
    with open(file, "rb") as content:
        while block := content.read(_BLOCK):
            found.update(block)
    return found.hexdigest()


def is_same(path: Path, name: str, *allowed: dict[str, Any]) -> bool:
    """Whether the folder is there; refuses one whose document says nothing that is allowed."""
    if not path.exists():
        return False
    found = _read(path / name)
    if {key: found[key] for key in found if key not in ("files", "checksum")} in allowed:
        return True
    raise DatasetError(
        f"'{path}' was collected otherwise; the same options, or another --out, needed"
    )
