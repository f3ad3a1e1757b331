"""How a converted folder was written: for engram's own readers, for people, and for resuming."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Collection
from pathlib import Path
from typing import Any

import engram
from engram.datasets.additions import ADDITIONS, chosen
from engram.datasets.checks import DatasetError, reading
from engram.datasets.collected import CollectedEpisodes, EpisodeSource

NAME = "engram.json"


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
    return is_same(path, path / NAME, with_additions(folder, chosen(**options)))


def write_json(path: Path, content: dict[str, Any]) -> None:
    """Writes a document of a converted folder."""
    path.write_text(json.dumps(content, indent=2) + "\n")


def is_same(path: Path, file: Path, *allowed: dict[str, Any]) -> bool:
    """Whether the folder is there; refuses one whose file says nothing that is allowed."""
    if not path.exists():
        return False
    with reading(file):
        found = json.loads(file.read_bytes())
    if found in allowed:
        return True
    raise DatasetError(
        f"'{path}' was collected otherwise; the same options, or another --out, needed"
    )
