"""Messages of ZeroMQ over TCP: ZMTP 3.0 without security, as REQ and REP sockets have it.

libzmq stores any number of frames until the last one of a message is there. Here bytes are counted
as they come.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from engram.servers.limits import CodecError, TooLargeError

_SIGNATURE = b"\xff" + bytes(8) + b"\x7f"
_MECHANISM = b"NULL".ljust(20, b"\0")
_GREETING = _SIGNATURE + bytes((3, 0)) + _MECHANISM + bytes(32)
_MORE, _LONG, _COMMAND = 1, 2, 4  # flags of a frame
_PEERS = {b"REQ": (b"REP", b"ROUTER"), b"REP": (b"REQ", b"DEALER")}
_LARGEST_COMMAND = 4096  # bytes
_SLICE = 1 << 20


class ZmtpError(Exception):
    """What the other end has sent is not ZMTP."""


class Wire:
    """A connection between a REQ and a REP socket.

    Args:
        kind: b"REQ" or b"REP", this end's.
        largest: Bytes of a message.
        receive: Called with the number of bytes that have been received.

    Methods raise OSError or EOFError where the connection ends.
    """

    def __init__(
        self,
        reader: asyncio.StreamReader,
        writer: asyncio.StreamWriter,
        kind: bytes,
        largest: int,
        receive: Callable[[int], None] = lambda count: None,
    ) -> None:
        self._reader = reader
        self._writer = writer
        self._kind = kind
        self._largest = largest
        self._receive = receive

    async def open(self) -> None:
        """The handshake."""
        self._writer.write(_GREETING)
        greeting = await self._reader.readexactly(10)
        if greeting[:1] != b"\xff" or greeting[9:] != b"\x7f":
            raise ZmtpError("no greeting of ZeroMQ")
        greeting = await self._reader.readexactly(54)
        if greeting[0] < 3 or greeting[2:22] != _MECHANISM:
            raise ZmtpError("another ZMTP than 3 without security")
        self._write(_COMMAND, b"\x05READY" + _property(b"Socket-Type", self._kind))
        flags, size = await self._head()
        if not flags & _COMMAND:
            raise ZmtpError("no command READY")
        ready = await self._body(size)
        kinds = [kind for kind in _PEERS[self._kind] if _property(b"Socket-Type", kind) in ready]
        if not ready.startswith(b"\x05READY") or not kinds:
            raise ZmtpError(f"a socket of a kind that {self._kind.decode()} does not talk to")

    async def read(self) -> bytes:
        """The next message. Raises TooLargeError, and CodecError if it has several frames."""
        frames: list[bytes] = []
        count, total, flags = 0, 0, _MORE
        while flags & _MORE:
            flags, size = await self._head()
            if flags & _COMMAND:
                self._answer(await self._body(size))
                flags = _MORE
                continue
            total += size + 2
            if total > self._largest + 4:
                raise TooLargeError
            body, count = await self._body(size), count + 1
            frames = [*frames[:1], body]
        if count != 2 or frames[0]:  # the first one separates addresses from the message
            raise CodecError(f"a message of {max(count - 1, 0)} frames, one needed")
        return frames[1]

    async def write(self, body: bytes) -> None:
        self._write(_MORE, b"")
        self._write(0, body)
        await self._writer.drain()

    async def wait(self) -> None:
        """Returns when there is something to read, which cannot be read any more."""
        await self._reader.readexactly(1)

    def close(self) -> None:
        self._writer.close()

    def _write(self, flags: int, body: bytes) -> None:
        small = len(body) < 256
        head = bytes((flags | (0 if small else _LONG),)) + len(body).to_bytes(
            1 if small else 8, "big"
        )
        self._writer.write(head)
        self._writer.write(body)

    async def _head(self) -> tuple[int, int]:
        """Flags and size of the next frame."""
        flags = (await self._reader.readexactly(1))[0]
        size = int.from_bytes(await self._reader.readexactly(8 if flags & _LONG else 1), "big")
        if flags > (_MORE | _LONG | _COMMAND) or (flags & _COMMAND and size > _LARGEST_COMMAND):
            raise ZmtpError("bytes that are no frame")
        return flags, size

    async def _body(self, size: int) -> bytes:
        body = bytearray()
        while len(body) < size:
            part = await self._reader.read(min(size - len(body), _SLICE))
            if not part:
                raise EOFError
            self._receive(len(part))
            body += part
        return bytes(body)

    def _answer(self, command: bytes) -> None:
        if command.startswith(b"\x04PING"):
            self._write(_COMMAND, b"\x04PONG" + command[7:])


def _property(name: bytes, value: bytes) -> bytes:
    return bytes((len(name),)) + name + len(value).to_bytes(4, "big") + value
