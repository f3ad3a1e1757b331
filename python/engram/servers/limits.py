"""Limits of what servers and clients may send: decided here, for every protocol and codec.

docs/security.md lists the readers and their limits.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

ANSWER = 64 << 20  # bytes of a server's answer
REQUEST = 256 << 20  # bytes of a client's request
UNANSWERED = 512 << 20  # bytes of requests that `engram serve` has received, of all clients
CLIENTS = 256  # connections to `engram serve`
OPENING = 10.0  # seconds for a handshake

VALUES = 100_000  # of a message: entries of its maps and lists
DEPTH = 32  # of maps and lists
AXES = 8  # of an array
TEXT = 1 << 20  # bytes of a text in msgpack; of JSON with other characters than ASCII
ACTIONS = 1000  # of a chunk
FRAMES = 1000  # of a request
WORDS = 2000  # characters of a failure's text
IDENTITY = 64 << 10  # bytes of what a policy tells of itself, as JSON
IDENTITY_DEPTH = 8  # of its maps and lists

SIDE = 1024  # pixels of an image that a server asks for
QUESTION = 64 << 20  # bytes of a question's images of such a size

_QUICK = 1 << 20  # bytes of a message that is decoded at once


class CodecError(Exception):
    """What was received is not what the protocol allows."""


class TooLargeError(Exception):
    """A message has more bytes than are allowed."""


async def decoded(read: Callable[[bytes], Any], data: bytes) -> Any:
    """``read(data)``, of a large message in a thread: deadlines and other clients do not wait."""
    return read(data) if len(data) <= _QUICK else await asyncio.to_thread(read, data)


class Traffic:
    """Clients of `engram serve`, and the bytes of their requests that have no answer yet."""

    def __init__(self) -> None:
        self._unanswered: dict[Any, int] = {}  # by client

    def enter(self, client: Any) -> bool:
        """False if there are too many clients."""
        if len(self._unanswered) >= CLIENTS:
            return False
        self._unanswered[client] = 0
        return True

    def receive(self, client: Any, count: int) -> bool:
        """Counts received bytes; False if there are too many, of all clients together."""
        if sum(self._unanswered.values()) + count > UNANSWERED:
            return False
        self._unanswered[client] = self._unanswered.get(client, 0) + count
        return True

    def answer(self, client: Any, count: int) -> None:
        """A request of ``count`` bytes has its answer."""
        if client in self._unanswered:
            self._unanswered[client] = max(0, self._unanswered[client] - count)

    def leave(self, client: Any) -> None:
        self._unanswered.pop(client, None)
