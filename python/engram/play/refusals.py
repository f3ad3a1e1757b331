"""Counts of what was refused, by reason, and a line a minute about it."""

from __future__ import annotations

import collections
import logging
import sys
import time
import traceback
from collections.abc import Callable, Mapping
from typing import TextIO

from aiohttp.http_exceptions import HttpProcessingError

_SECONDS = 60.0  # between two lines


class Refusals:
    """What was refused so far. However much that is, it is at most one line a minute."""

    def __init__(
        self, out: TextIO | None = None, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._out = out
        self._clock = clock
        self._counts: collections.Counter[str] = collections.Counter()
        self._told: collections.Counter[str] = collections.Counter()
        self._next = clock()

    @property
    def counts(self) -> Mapping[str, int]:
        """Numbers by reason, since the start."""
        return self._counts

    def add(self, reason: str) -> None:
        """Counts one; `reason` is a text of the program's own."""
        self._counts[reason] += 1
        if self._clock() >= self._next:
            self._next = self._clock() + _SECONDS
            self._print(self._counts - self._told, "refused")
            self._told = self._counts.copy()

    def close(self) -> None:
        """Prints the sums."""
        self._print(self._counts, "refused in all")

    def _print(self, counts: Mapping[str, int], words: str) -> None:
        if counts:
            sums = ", ".join(f"{count} {reason}" for reason, count in sorted(counts.items()))
            print(f"engram play: {words}: {sums}", file=self._out or sys.stderr, flush=True)

    def logger(self) -> logging.Logger:
        """A log for the HTTP library, which would print a traceback for every broken request."""
        log = logging.Logger("engram.play", logging.WARNING)
        log.addHandler(_Handler(self))
        return log


class _Handler(logging.Handler):
    def __init__(self, refusals: Refusals) -> None:
        super().__init__()
        self._refusals = refusals
        self._next = 0.0

    def emit(self, record: logging.LogRecord) -> None:
        error = record.exc_info[1] if record.exc_info else None
        if isinstance(error, (HttpProcessingError, ValueError, LookupError)):
            self._refusals.add("broken request")
            return
        self._refusals.add("failed request")
        if error is not None and time.monotonic() >= self._next:  # a defect of the server
            self._next = time.monotonic() + _SECONDS
            traceback.print_exception(error, file=sys.stderr)
