"""Connections to the server: unauthenticated clients are few at a time, and only for a moment.

Any client that reaches the port can connect to it. A connection is unauthenticated until it has
sent a request with the token. Unauthenticated clients may neither use up the descriptors nor keep
the page out: when there are too many, the oldest makes room for the newest, which may be the page.
"""

from __future__ import annotations

import asyncio
import dataclasses
import errno
import socket
import time
from collections.abc import Callable, Iterator
from typing import Any

from engram.play.refusals import Refusals

UNAUTHENTICATED_OF_AN_ADDRESS = 16
UNAUTHENTICATED = 64
MOST = 256  # with the page's own
SECONDS = 10.0  # for a client's first request with the token
_PAUSE = 0.05  # seconds, when the system has no descriptor left


@dataclasses.dataclass
class _Connection:
    transport: asyncio.Transport
    address: str
    since: float
    known: bool = False  # it has sent the token


class Connections:
    """Accepts connections for an HTTP protocol, within the limits above."""

    def __init__(self, refusals: Refusals) -> None:
        self._refusals = refusals
        self._open: dict[Any, _Connection] = {}  # by transport
        self._tasks: list[asyncio.Task[None]] = []
        self._sockets: list[socket.socket] = []

    def listen(self, host: str, port: int, protocol: Callable[[], Any]) -> tuple[Any, ...]:
        """Begins to accept connections; returns the first address. Raises OSError."""
        failure = OSError(f"'{host}' has no address")
        for family, address in _addresses(host, port):
            if self._sockets and not port:  # a free port is the same for all addresses
                address = (address[0], self._sockets[0].getsockname()[1], *address[2:])
            try:
                one = socket.create_server(address, family=family, backlog=UNAUTHENTICATED)
            except OSError as error:
                if error.errno not in (errno.EADDRNOTAVAIL, errno.EAFNOSUPPORT):
                    raise
                failure = error  # localhost may have an address that this machine lacks
                continue
            one.setblocking(False)
            self._sockets.append(one)
        if not self._sockets:
            raise failure
        loop = asyncio.get_running_loop()
        self._tasks = [loop.create_task(self._accept(one, protocol)) for one in self._sockets]
        self._tasks.append(loop.create_task(self._watch()))
        first: tuple[Any, ...] = self._sockets[0].getsockname()
        return first

    def recognize(self, transport: Any) -> None:
        """The connection has sent the token."""
        connection = self._open.get(transport)
        if connection is not None:
            connection.known = True

    async def close(self) -> None:
        """Accepts no more; open connections are the protocol's to close."""
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        for one in self._sockets:
            one.close()

    async def _accept(self, listening: socket.socket, protocol: Callable[[], Any]) -> None:
        loop = asyncio.get_running_loop()
        while True:
            try:
                accepted, address = await loop.sock_accept(listening)
            except OSError:  # no descriptor left, or the other end has gone
                self._drop(self._unauthenticated()[:1], "connection without a descriptor")
                await asyncio.sleep(_PAUSE)
                continue
            self._make_room(address[0])
            if len(self._open) >= MOST:
                self._refusals.add("connection too many")
                accepted.close()
                await asyncio.sleep(0)
                continue
            try:
                transport, _ = await loop.connect_accepted_socket(protocol, accepted)
            except Exception:  # it was closed at once; the next one is accepted all the same
                self._refusals.add("failed connection")
                accepted.close()
                continue
            self._open[transport] = _Connection(transport, address[0], time.monotonic())

    def _make_room(self, address: str) -> None:
        """Drops an unauthenticated client where one more would be too many."""
        self._forget_closed()
        clients = self._unauthenticated()
        same = [one for one in clients if one.address == address]
        if len(same) >= UNAUTHENTICATED_OF_AN_ADDRESS:
            self._drop(same[:1], "connection of an address with many")
        elif len(clients) >= UNAUTHENTICATED:
            self._drop(clients[:1], "connection of many")

    async def _watch(self) -> None:
        """Drops unauthenticated clients that are silent or slow."""
        while True:
            await asyncio.sleep(1)
            self._forget_closed()
            late = time.monotonic() - SECONDS
            self._drop(
                [one for one in self._unauthenticated() if one.since < late], "idle connection"
            )

    def _unauthenticated(self) -> list[_Connection]:
        """The oldest first."""
        return [one for one in self._open.values() if not one.known]

    def _drop(self, connections: list[_Connection], reason: str) -> None:
        for one in connections:
            self._refusals.add(reason)
            one.transport.abort()
            self._open.pop(one.transport, None)

    def _forget_closed(self) -> None:
        for transport in [one for one in self._open if one.is_closing()]:
            del self._open[transport]


def _addresses(host: str, port: int) -> Iterator[tuple[socket.AddressFamily, Any]]:
    found = socket.getaddrinfo(host or None, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
    for family, *_, address in dict.fromkeys(found):
        if family in (socket.AF_INET, socket.AF_INET6):
            yield family, address
