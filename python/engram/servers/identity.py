"""What a policy tells of itself, such as its checkpoint: a run's folder keeps it."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from engram.servers import limits

CHECKPOINT = "checkpoint"


def identity_of_file(file: str | Path) -> dict[str, str]:
    """The name of a policy's file, and the hash of its bytes."""
    digest = hashlib.sha256()
    with Path(file).open("rb") as source:
        while part := source.read(1 << 20):
            digest.update(part)
    return {"policy": Path(file).name, CHECKPOINT: f"sha256:{digest.hexdigest()}"}


def identity_in(metadata: Any) -> dict[str, Any]:
    """A server's metadata as JSON has them; of large ones the checkpoint alone."""
    told: dict[str, Any] = _plain(metadata) if isinstance(metadata, Mapping) else {}
    for kept in (told, {name: told[name] for name in (CHECKPOINT,) if name in told}):
        if len(packed_identity(kept)) <= limits.IDENTITY:
            return kept
    return {}


def packed_identity(identity: Mapping[str, Any]) -> bytes:
    return json.dumps(identity).encode()


def _plain(value: Any, depth: int = 0) -> Any:
    """Maps, lists, texts and numbers; null in place of anything else."""
    if depth >= limits.IDENTITY_DEPTH:
        return None
    if isinstance(value, Mapping):
        return {_text(name): _plain(part, depth + 1) for name, part in value.items()}
    if isinstance(value, (np.ndarray, np.generic)):
        return _plain(value.tolist(), depth)
    if isinstance(value, (list, tuple)):
        return [_plain(part, depth + 1) for part in value]
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if isinstance(value, int) else None


def _text(value: Any) -> str:
    return str(value).encode(errors="replace").decode()
