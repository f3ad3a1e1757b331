"""Shared parts of the converters: results of many threads in order, PNG."""

from __future__ import annotations

import concurrent.futures
import contextlib
import os
import struct
import threading
import zlib
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from typing import Any, TypeVar

import numpy as np

In = TypeVar("In")
Out = TypeVar("Out")


class _Calls:
    """Calls in threads. When it ends, none runs any more, and none begins.

    An executor alone forgets a thread whose start a Ctrl-C interrupts: it does not wait for it.
    """

    def __init__(self, threads: int) -> None:
        self._executor = concurrent.futures.ThreadPoolExecutor(threads)
        self._changed = threading.Condition()
        self._running = 0
        self._ended = False

    def __enter__(self) -> _Calls:
        return self

    def __exit__(self, *_: object) -> None:
        with self._changed:
            self._ended = True
        try:
            self._executor.shutdown(cancel_futures=True)
        finally:  # also after a second Ctrl-C
            with self._changed:
                self._changed.wait_for(lambda: not self._running)

    def submit(self, function: Callable[..., Out], *args: Any) -> concurrent.futures.Future[Out]:
        return self._executor.submit(self._call, function, *args)

    def _call(self, function: Callable[..., Out], *args: Any) -> Out:
        with self._changed:
            if self._ended:
                raise concurrent.futures.CancelledError
            self._running += 1
        try:
            return function(*args)
        finally:
            with self._changed:
                self._running -= 1
                self._changed.notify_all()


@contextlib.contextmanager
def in_order(
    function: Callable[[In], Out], items: Iterable[In], jobs: int = 0
) -> Iterator[Iterator[Out]]:
    """function(item) for every item, in their order, from `jobs` threads (0: one per core).

    For use with ``with``, at whose end no function runs any more. Only a few results are buffered.
    Threads are enough: inflating and PNG work outside Python's lock.
    """
    jobs = jobs or os.cpu_count() or 1
    with _Calls(jobs) as calls:
        yield _results(calls, function, items, 2 * jobs)


def _results(
    calls: _Calls, function: Callable[[In], Out], items: Iterable[In], most: int
) -> Iterator[Out]:
    waiting: deque[concurrent.futures.Future[Out]] = deque()
    for item in items:
        waiting.append(calls.submit(function, item))
        if len(waiting) > most:
            yield waiting.popleft().result()
    while waiting:
        yield waiting.popleft().result()


_END = object()


@contextlib.contextmanager
def ahead(items: Iterable[In], count: int = 1) -> Iterator[Iterator[In]]:
    """The items, of which a thread makes `count` more while one is used; as ``in_order``."""
    with _Calls(1) as calls:
        yield _next_ones(calls, iter(items), count)


def _next_ones(calls: _Calls, iterator: Iterator[In], count: int) -> Iterator[In]:
    coming = deque(calls.submit(next, iterator, _END) for _ in range(count))
    while (item := coming.popleft().result()) is not _END:
        coming.append(calls.submit(next, iterator, _END))
        yield item


def packed(image: np.ndarray) -> np.ndarray:
    """The image without gaps. Copies pixel by pixel, in half the time of byte by byte."""
    if image.ndim == 3 and image.itemsize == image.strides[-1] == 1:
        pixels = np.ascontiguousarray(image.view(f"V{image.shape[-1]}"))
        return pixels.view(np.uint8).reshape(image.shape)
    return np.ascontiguousarray(image)


# Constants of PNG files.
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
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(filtered.data, _LEVEL)), (b"IEND", b""))
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
