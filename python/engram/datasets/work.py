"""Shared parts of the converters: results of many threads in order, PNG."""

from __future__ import annotations

import concurrent.futures
import os
import struct
import zlib
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

import numpy as np

In = TypeVar("In")
Out = TypeVar("Out")


def in_order(function: Callable[[In], Out], items: Iterable[In], jobs: int = 0) -> Iterator[Out]:
    """function(item) for every item, in their order, from `jobs` threads (0: one per core).

    Only a few results are buffered. Threads are enough: inflating and PNG work outside
    Python's lock.
    """
    jobs = jobs or os.cpu_count() or 1
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        waiting: deque[concurrent.futures.Future[Out]] = deque()
        try:
            for item in items:
                waiting.append(pool.submit(function, item))
                if len(waiting) > 2 * jobs:
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()
        finally:
            for future in waiting:
                future.cancel()


_END = object()


def ahead(items: Iterable[In]) -> Iterator[In]:
    """The items, each made by a thread while the one before is used."""
    iterator = iter(items)
    with concurrent.futures.ThreadPoolExecutor(1) as pool:
        coming = pool.submit(next, iterator, _END)
        while (item := coming.result()) is not _END:
            coming = pool.submit(next, iterator, _END)
            yield item  # type: ignore[misc]


def packed(image: np.ndarray) -> np.ndarray:
    """The same picture without gaps. Copies pixel by pixel, in half the time of byte by byte."""
    if image.ndim == 3 and image.itemsize == image.strides[-1] == 1:
        pixels = np.ascontiguousarray(image.view(f"V{image.shape[-1]}"))
        return pixels.view(np.uint8).reshape(image.shape)
    return np.ascontiguousarray(image)


# Of PNG files.
_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_GREY, _RGB = 0, 2
_DIFFERENCES = 1
_LEVEL = 1  # of deflate


def png(image: np.ndarray) -> bytes:
    """An image of (H, W, 3) bytes, or of (H, W) numbers of 16 bits, as a PNG file.

    Every line is stored as differences to the pixel before (PNG's filter 1). Trying all filters, as
    Pillow does, takes twice as long, and files of rendered scenes become no smaller.
    """
    height, width = image.shape[:2]
    samples = packed(image)
    if image.itemsize > 1:
        samples = samples.astype(image.dtype.newbyteorder(">"))
    lines = samples.view(np.uint8).reshape(height, -1)
    pixel = lines.shape[1] // width  # in bytes
    filtered = np.empty((height, 1 + lines.shape[1]), np.uint8)
    filtered[:, 0] = _DIFFERENCES
    filtered[:, 1 : 1 + pixel] = lines[:, :pixel]
    np.subtract(lines[:, pixel:], lines[:, :-pixel], out=filtered[:, 1 + pixel :])
    color = _RGB if image.ndim == 3 else _GREY
    header = struct.pack(">IIBBBBB", width, height, 8 * image.itemsize, color, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(filtered, _LEVEL)), (b"IEND", b""))
    return _SIGNATURE + b"".join(_chunk(kind, data) for kind, data in chunks)


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def pngs(images: np.ndarray) -> list[bytes]:
    """PNG files of images as ``png`` takes them; equal ones, of which waiting makes many, once."""
    made: dict[bytes, bytes] = {}
    files = []
    for image in images:
        without_gaps = packed(image)
        pixels = without_gaps.tobytes()
        if pixels not in made:
            made[pixels] = png(without_gaps)
        files.append(made[pixels])
    return files
