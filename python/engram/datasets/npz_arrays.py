"""Arrays of .npz files from others, read if their headers have the required type and shape."""

from __future__ import annotations

import zipfile
from typing import Any

import numpy as np

from engram.datasets.checks import DatasetError

ANY = -1  # size of a dimension, up to _MOST
_MOST = 100_000
_LARGEST_TEXT = 1 << 16  # bytes of one text
_LARGEST_TEXTS = 1 << 24  # bytes of an array of texts


def read_array(
    archive: zipfile.ZipFile,
    name: str,
    kind: type | None,
    expected: tuple[int, ...],
    where: str = "",
) -> np.ndarray:
    """One array; kind: its type, None for texts; where: the last words of refusals."""
    member = archive.getinfo(f"{name}.npy")
    if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise DatasetError(f"{name} is neither stored nor deflated")
    opened: Any = archive.open(member)  # its type does not know readinto
    with opened as file:
        version = np.lib.format.read_magic(file)
        readers = {
            (1, 0): np.lib.format.read_array_header_1_0,
            (2, 0): np.lib.format.read_array_header_2_0,
        }
        if version not in readers:
            raise DatasetError(f"{name} has a header of version {version}")
        found, is_fortran, dtype = readers[version](file)
        if not _has_type(dtype, found, kind) or not _fits(found, expected):
            needed = "a text" if kind is None else np.dtype(kind)
            raise DatasetError(
                f"{name} is {dtype} of shape {found}, {needed} of shape {expected} expected{where}"
            )
        array = np.empty(found, dtype, "F" if is_fortran else "C")
        if file.readinto(array.reshape(-1, order="A").view(np.uint8)) != array.nbytes:
            raise DatasetError(f"{name} ends too early")
        file.read(1)  # at the end, the archive's checksum is compared
    return array


def _has_type(dtype: np.dtype, shape: tuple[int, ...], kind: type | None) -> bool:
    if kind is not None:
        return dtype == kind
    count = max(1, int(np.prod(shape, dtype=object)))
    return (
        dtype.kind == "U"
        and 0 < dtype.itemsize <= _LARGEST_TEXT
        and dtype.itemsize * count <= _LARGEST_TEXTS
    )


def _fits(found: tuple[int, ...], expected: tuple[int, ...]) -> bool:
    return len(found) == len(expected) and all(
        size == needed or (needed == ANY and size <= _MOST) for size, needed in zip(found, expected)
    )
