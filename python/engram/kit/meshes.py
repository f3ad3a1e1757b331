"""Points of meshes in files: OBJ and STL."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engram.errors import InvalidArgumentError, IoError

MOST_POINTS = 20_000
_STL_HEADER, _STL_COUNT = 80, 4  # bytes
_STL_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("unused", "<u2")])


def read_points(file: str | os.PathLike[str]) -> NDArray[np.float64]:
    """The different points of a mesh (n, 3), as the file has them.

    Raises:
        IoError: The file cannot be read.
        InvalidArgumentError: It is no mesh.
    """
    path = Path(file)
    readers = {".obj": _obj_points, ".stl": _stl_points}
    if path.suffix.lower() not in readers:
        raise InvalidArgumentError(f"{path}: a file that ends in .obj or .stl needed")
    try:
        content = path.read_bytes()
    except OSError as error:
        raise IoError(f"{path}: {error.strerror}") from None
    try:
        points = readers[path.suffix.lower()](content)
    except (ValueError, IndexError) as error:
        raise InvalidArgumentError(f"{path}: {error}") from None
    return np.unique(points, axis=0)


def _obj_points(content: bytes) -> NDArray[np.float64]:
    rows = [line.split()[1:4] for line in content.splitlines() if line[:2] in (b"v ", b"v\t")]
    if not rows:
        raise ValueError("no OBJ file: it has no vertices")
    for row in rows:
        if len(row) < 3:
            raise ValueError(f"a vertex has {len(row)} coordinates, 3 needed")
    return np.array([[float(one) for one in row] for row in rows])


def _stl_points(content: bytes) -> NDArray[np.float64]:
    """Binary files have a number of facets that fits their length; others are text."""
    start = _STL_HEADER + _STL_COUNT
    if len(content) >= start:
        count = int.from_bytes(content[_STL_HEADER:start], "little")
        if len(content) == start + count * _STL_FACET.itemsize:
            facets = np.frombuffer(content, _STL_FACET, count, start)
            return facets["corners"].reshape(-1, 3).astype(np.float64)
    words = content.split()
    if not content.lstrip().startswith(b"solid"):
        raise ValueError("no STL file: neither text nor the length of a binary one")
    places = [i for i, word in enumerate(words) if word == b"vertex"]
    if not places:
        raise ValueError("no STL file: it has no vertices")
    return np.array([[float(words[i + k]) for k in (1, 2, 3)] for i in places])
