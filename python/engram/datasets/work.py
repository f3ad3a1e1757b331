"""What the converters share: results of many threads in order, folders that appear whole, PNG."""

from __future__ import annotations

import concurrent.futures
import contextlib
import io
import os
import shutil
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TypeVar

import numpy as np
from PIL import Image

In = TypeVar("In")
Out = TypeVar("Out")


def in_order(function: Callable[[In], Out], items: Iterable[In], jobs: int = 0) -> Iterator[Out]:
    """function(item) for every item, in their order, from `jobs` threads (0: one per core).

    No more than a few results are kept waiting. Threads are enough: inflating and PNG work outside
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


@contextlib.contextmanager
def new_folder(target: Path) -> Iterator[Path]:
    """A folder to fill; it replaces `target` when the block ends well."""
    target.parent.mkdir(parents=True, exist_ok=True)
    for leftover in target.parent.glob(f"{target.name}.*.engram-tmp"):
        shutil.rmtree(leftover, ignore_errors=True)
    path = target.parent / f"{target.name}.{os.getpid()}.engram-tmp"
    path.mkdir()
    try:
        yield path
        if target.exists():
            shutil.rmtree(target)
        path.rename(target)
    except BaseException:
        shutil.rmtree(path, ignore_errors=True)
        raise


def png(image: np.ndarray) -> bytes:
    """An image of (H, W, 3) bytes as a PNG file."""
    out = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(image)).save(out, "PNG", compress_level=1)
    return out.getvalue()
