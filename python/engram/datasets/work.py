"""Shared parts of the converters: results of many threads in order, PNG."""

from __future__ import annotations

import concurrent.futures
import io
import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

import numpy as np
from PIL import Image

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


def png(image: np.ndarray) -> bytes:
    """An image of (H, W, 3) bytes as a PNG file."""
    out = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(image)).save(out, "PNG", compress_level=1)
    return out.getvalue()


def pngs(images: np.ndarray) -> list[bytes]:
    """PNG files of images, (T, H, W, 3) bytes; equal ones, of which waiting makes many, once."""
    made: dict[bytes, bytes] = {}
    files = []
    for image in images:
        pixels = image.tobytes()
        if pixels not in made:
            made[pixels] = png(image)
        files.append(made[pixels])
    return files
