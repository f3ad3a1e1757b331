"""Fuzzing of what lies under the codecs: bytes of ZeroMQ, HTTP and WebSockets, and images as PNG.

    python python/tests/servers/fuzz_wires.py [COUNT [FIRST]]

Case n is the same on every machine. Readers of ZeroMQ get a stream; the servers of `engram serve`
get a connection each, and have to answer a sound request at the end.
"""

from __future__ import annotations

import asyncio
import contextlib
import functools
import http.client
import random
import resource
import socket
import struct
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from policy_servers import in_thread

from engram.datasets.stored import images
from engram.datasets.work import png
from engram.servers.codecs import pack_json, pack_openpi
from engram.servers.keys import keys_of
from engram.servers.limits import CodecError, TooLargeError
from engram.servers.serving import protocols
from engram.servers.serving.policies import ServedPolicy
from engram.servers.serving.reading import Reader
from engram.servers.zmtp import Wire, ZmtpError

GREETING = b"\xff" + bytes(8) + b"\x7f\x03\x00NULL" + bytes(16 + 32)
READY = b"\x04\x19\x05READY\x0bSocket-Type\x00\x00\x00\x03REQ"
PICTURE = png(np.arange(128 * 128 * 3, dtype=np.uint8).reshape(128, 128, 3))


def damaged(rng: random.Random, good: bytes, pieces: list[bytes]) -> bytes:
    """A sound stream with one to six changes, or random bytes."""
    if rng.random() < 0.1:
        return rng.randbytes(rng.randrange(200))
    bad = bytearray(good)
    for _ in range(rng.randint(1, 6)):
        at = rng.randrange(len(bad) + 1)
        match rng.randrange(4):
            case 0:
                bad[at:at] = rng.choice(pieces) * rng.choice((1, 1, 40))
            case 1:
                del bad[at : at + rng.randint(1, 9)]
            case 2:
                bad[at : at + 1] = rng.randbytes(1)
            case _:
                bad[at:at] = bad[at : at + rng.randint(1, 60)] * rng.choice((1, 9))
    return bytes(bad)


# --- streams and images, without a connection ---


class _Sink:
    """A writer that keeps nothing."""

    def write(self, data: bytes) -> None:
        pass

    async def drain(self) -> None:
        pass


def read_zeromq(data: bytes) -> None:
    async def run() -> None:
        reader = asyncio.StreamReader()
        reader.feed_data(data)
        reader.feed_eof()
        sink: Any = _Sink()
        wire = Wire(reader, sink, b"REP", 1 << 20)
        await wire.open()
        while True:
            await wire.read()

    with contextlib.suppress(ZmtpError, CodecError, TooLargeError, EOFError):
        asyncio.run(run())


def read_picture(data: bytes) -> None:
    with contextlib.suppress(Exception):  # checks.reading makes a sentence of it
        images([data])


def _zeromq(rng: random.Random) -> bytes:
    frames = b"\x01\x00" + b"\x00\x05hello" + b"\x01\x00\x02" + struct.pack(">Q", 300) + bytes(300)
    pieces = [b"\x01\x00", b"\x03" + b"\xff" * 8, b"\x04\xff", b"\x02" + struct.pack(">Q", 1 << 40)]
    stream = damaged(rng, READY + frames, pieces)
    return damaged(rng, GREETING, pieces) + stream if rng.random() < 0.1 else GREETING + stream


def _picture(rng: random.Random) -> bytes:
    side = struct.pack(">I", rng.choice((0, 1, 13_300, 1 << 31)))
    return damaged(rng, PICTURE, [b"IDAT", b"IEND", b"\x00\x00\x00\x0dIHDR" + side * 2, side])


READERS: dict[str, tuple[Callable[[random.Random], bytes], Callable[[bytes], None]]] = {
    "zeromq": (_zeromq, read_zeromq),
    "png": (_picture, read_picture),
}


# --- servers ---


class _Still(ServedPolicy):
    def answer(self, request: Any) -> Any:
        return np.zeros((1, 7), np.float32)


def _http(rng: random.Random) -> bytes:
    body = pack_json({"observation/state": np.zeros((1, 7)), "instruction": ""})
    head = (
        "POST /act HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
        f"Connection: close\r\nContent-Length: {len(body)}\r\n\r\n"
    )
    pieces = [b"\r\n", b"Transfer-Encoding: chunked\r\n", b"Content-Length: 99999999999\r\n", b"\0"]
    return damaged(rng, head.encode() + body, pieces)


def _web_socket(rng: random.Random) -> bytes:
    head = (
        b"GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        b"Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n\r\n"
    )
    body = pack_openpi({"observation/state": np.zeros((1, 7), np.float32), "prompt": ""})
    frame = b"\x82\xfe" + struct.pack(">H", len(body)) + bytes(4) + body
    pieces = [
        b"\x82\xff" + b"\x7f" * 8,
        b"\x02\x80" + bytes(4),
        b"\x80\x80" + bytes(4),
        b"\x88\x80",
    ]
    if rng.random() < 0.1:
        head = damaged(rng, head, [b"\r\n", b"Sec-WebSocket-Extensions: permessage-deflate\r\n"])
    return head + damaged(rng, frame, pieces)


SERVERS: dict[str, tuple[Any, str, Callable[[random.Random], bytes]]] = {
    "http": (protocols.serve_act, "act", _http),
    "websocket": (protocols.serve_openpi, "openpi", _web_socket),
    "zeromq server": (protocols.serve_gr00t, "gr00t", _zeromq),
}


def send(port: int, data: bytes) -> None:
    """Sends the bytes and their end, and reads until the server ends the connection."""
    address = ("127.0.0.1", port)
    with socket.create_connection(address, timeout=20) as one, contextlib.suppress(ConnectionError):
        one.sendall(data)
        one.shutdown(socket.SHUT_WR)
        while one.recv(1 << 16):
            pass


def is_alive(port: int, name: str) -> bool:
    if name == "http":
        connection = http.client.HTTPConnection("127.0.0.1", port, timeout=20)
        connection.request("GET", "/health")
        alive = connection.getresponse().status in (200, 404)
        connection.close()
        return alive
    with socket.create_connection(("127.0.0.1", port), timeout=20) as one:
        one.sendall(GREETING if name == "zeromq server" else b"GET /healthz HTTP/1.1\r\n\r\n")
        return bool(one.recv(64))


# --- cases ---


def play(name: str, first: int, count: int) -> tuple[float, list[str]]:
    """Plays cases of a reader; returns the longest time of one, and what does not hold."""
    worst, findings = 0.0, []

    def one(number: int, make: Callable[[random.Random], bytes], read: Any) -> None:
        nonlocal worst
        data = make(random.Random(f"{name}{number}"))
        begin = time.perf_counter()
        try:
            read(data)
        except Exception as error:
            findings.append(f"{name} {number}: {type(error).__name__}: {str(error)[:200]}")
        worst = max(worst, time.perf_counter() - begin)

    if name in READERS:
        make, read = READERS[name]
        for number in range(first, first + count):
            one(number, make, read)
        return worst, findings
    serve, protocol, make = SERVERS[name]
    reader = Reader(_Still(), keys_of(protocol, "mikasa"))
    with in_thread(functools.partial(serve, reader, "127.0.0.1", 0)) as port:
        for number in range(first, first + count):
            one(number, make, functools.partial(send, port))
        if not is_alive(port, name):
            findings.append(f"{name}: a sound request has no answer at the end")
    return worst, findings


def main() -> int:
    """The command."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    first = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    found = []
    for name in [*READERS, *SERVERS]:
        worst, findings = play(name, first, count)
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss >> 10
        print(f"{name}: {count} cases, longest {worst:.3f} s, peak {memory} MiB", *findings[:5])
        found += findings
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
