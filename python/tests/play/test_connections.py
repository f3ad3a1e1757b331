"""Connections of clients, and requests that are none: few, short and counted."""

from __future__ import annotations

import asyncio
import contextlib
import io
import random
import socket
import sys
import time
from collections.abc import Iterator

import pytest
from play_server import SECONDS, Server, serving

from engram.play import connections
from engram.play.connections import Connections
from engram.play.refusals import Refusals

TASK = "RememberColor3-VLA-v0"
BROKEN = [
    b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",  # TLS
    b"GET / HTTP/9.9\r\n\r\n",
    b"GET\r\n\r\n",
    b"GET / HTTP/1.1\r\nHost: x\r\nHost\r\n\r\n",
    b"GET / HTTP/1.1\r\n: x\r\n\r\n",
    b"GET / HTTP/1.1\r\nHost: " + b"x" * 20_000 + b"\r\n\r\n",
    b"GET /" + b"x" * 20_000 + b" HTTP/1.1\r\nHost: x\r\n\r\n",
    b"POST / HTTP/1.1\r\nHost: x\r\nContent-Length: -1\r\n\r\n",
    b"POST / HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\nzz\r\n",
    b"GET http://[::1/ HTTP/1.1\r\nHost: x\r\n\r\n",
    b"GET /\xff\xfe HTTP/1.1\r\nHost: x\r\n\r\n",
    b"\x00" * 100 + b"\r\n\r\n",
    b"\x1b]0;title\x07 / HTTP/1.1\r\n\r\n",
]


def unauthenticated_client(server: Server, data: bytes = b"") -> socket.socket:
    host, _, port = server.host.rpartition(":")
    one = socket.create_connection((host, int(port)), timeout=SECONDS)
    if data:
        one.sendall(data)
    return one


def answer_to(server: Server, data: bytes) -> bytes:
    """All that the server says until it closes the connection."""
    parts = []
    with unauthenticated_client(server) as one, contextlib.suppress(ConnectionError):
        one.sendall(data)
        one.shutdown(socket.SHUT_WR)
        while part := one.recv(65536):
            parts.append(part)
    return b"".join(parts)


@pytest.fixture
def own(tmp_path) -> Iterator[Server]:
    """A server of one test, with few descriptors."""
    few = ("prlimit", "--nofile=160", sys.executable, "-m")
    with serving(tmp_path / "out", program=few) as running:
        yield running


def test_idle_connections_do_not_keep_the_page_out(own: Server):
    with contextlib.ExitStack() as open_ones:
        for i in range(400):
            data = b"GET / HT" if i % 2 else b""
            with contextlib.suppress(ConnectionError):
                open_ones.enter_context(unauthenticated_client(own, data))
        assert len(own.get("tasks.json")) >= 97
        with own.page() as page:
            page.play(TASK, 3)
            page.step([0] * 7)
        counts = own.refused()
    log = own.end()
    assert sum(counts.values()) >= 300
    assert len(log.splitlines()) <= 3, log
    assert "Traceback" not in log


def test_broken_requests_are_counted_without_a_traceback(own: Server):
    for data in BROKEN:
        answer = answer_to(own, data)
        assert answer == b"" or answer.split()[1] in (b"400", b"403", b"431"), data
    assert own.refused()["broken request"] >= len(BROKEN) - 4
    log = own.end()
    assert "Traceback" not in log
    assert "broken request" in log
    assert log.replace("\n", "").isprintable()
    assert len(log.splitlines()) <= 3


def test_random_requests_leave_the_server_as_it_was(own: Server):
    rng = random.Random(11)
    good = f"GET /{own.token}/tasks.json HTTP/1.1\r\nHost: {own.host}\r\n\r\n".encode()
    for _ in range(500):
        data = bytearray(rng.choice([good, *BROKEN]))
        for _ in range(rng.randint(1, 6)):
            at = rng.randrange(len(data) + 1)
            data[at : at + rng.randint(0, 4)] = rng.randbytes(rng.randint(0, 5))
        answer_to(own, bytes(data))
    assert len(own.get("tasks.json")) >= 97
    log = own.end()
    assert "Traceback" not in log
    assert len(log.splitlines()) <= 4


def test_clients_keep_no_connection(own: Server):
    """After a refused request, the connection is closed: nothing more can be tried with it."""
    with unauthenticated_client(
        own, b"GET /wrong/ HTTP/1.1\r\nHost: " + own.host.encode() + b"\r\n\r\n"
    ) as one:
        data = b""
        while part := one.recv(65536):
            data += part
    assert data.startswith(b"HTTP/1.1 403")


# --- limits, with a protocol that answers nothing ---


class Listening(asyncio.Protocol):
    """Knows a connection when it sends `known`."""

    def __init__(self, known: Connections) -> None:
        self._connections = known

    def connection_made(self, transport) -> None:
        self._transport = transport

    def data_received(self, data: bytes) -> None:
        if data == b"known":
            self._connections.recognize(self._transport)
            self._transport.write(b"yes")


async def connect(port: int, address: str = "127.0.0.1", known: bool = False):
    reader, writer = await asyncio.open_connection("127.0.0.1", port, local_addr=(address, 0))
    if known:
        writer.write(b"known")
        assert await reader.readexactly(3) == b"yes"
    return reader, writer


async def closed(reader: asyncio.StreamReader, seconds: float = 0.3) -> bool:
    try:
        return await asyncio.wait_for(reader.read(1), seconds) == b""
    except ConnectionError:
        return True
    except asyncio.TimeoutError:
        return False


def run_with(test) -> Refusals:
    """Runs a test with listening connections; returns what was refused."""
    refusals = Refusals(io.StringIO())

    async def main() -> None:
        listening = Connections(refusals)
        port = listening.listen("127.0.0.1", 0, lambda: Listening(listening))[1]
        try:
            await test(port)
        finally:
            await listening.close()

    asyncio.run(main())
    return refusals


def test_the_oldest_clients_make_room():
    async def test(port: int) -> None:
        page = await connect(port, known=True)
        many = [await connect(port) for _ in range(connections.UNAUTHENTICATED_OF_AN_ADDRESS + 3)]
        others = [await connect(port, f"127.0.0.{i}") for i in range(2, 6)]
        assert [await closed(one[0]) for one in many[:4]] == [True, True, True, False]
        assert not await closed(many[-1][0])
        assert not await closed(page[0])
        for i in range(2, 12):
            for _ in range(connections.UNAUTHENTICATED_OF_AN_ADDRESS - 1):
                others.append(await connect(port, f"127.0.0.{i}"))
        still = [one for one in [*many, *others] if not await closed(one[0], 0.01)]
        assert len(still) <= connections.UNAUTHENTICATED
        assert not await closed(page[0])

    counts = run_with(test).counts
    assert counts["connection of an address with many"] == 3


def test_silent_clients_are_dropped_and_the_page_is_not(monkeypatch):
    monkeypatch.setattr(connections, "SECONDS", 0.5)

    async def test(port: int) -> None:
        page = await connect(port, known=True)
        silent, drips = await connect(port), await connect(port)
        for _ in range(20):
            await asyncio.sleep(0.1)
            drips[1].write(b"G")
        assert await closed(silent[0])
        assert await closed(drips[0])
        assert not await closed(page[0])

    assert run_with(test).counts["idle connection"] == 2


def test_there_is_a_last_limit(monkeypatch):
    monkeypatch.setattr(connections, "MOST", 5)

    async def test(port: int) -> None:
        pages = [await connect(port, known=True) for _ in range(5)]
        assert await closed((await connect(port))[0])
        pages[0][1].close()
        await pages[0][1].wait_closed()
        await asyncio.sleep(0.1)
        await connect(port, known=True)

    assert run_with(test).counts["connection too many"] == 1


def test_a_line_a_minute():
    out, times = io.StringIO(), [100.0]
    refusals = Refusals(out, lambda: times[-1])
    for now in (100.0, 101.0, 130.0, 161.0, 162.0):
        times.append(now)
        refusals.add("token")
    refusals.add("host")
    refusals.close()
    assert out.getvalue() == (
        "engram play: refused: 1 token\n"
        "engram play: refused: 3 token\n"
        "engram play: refused in all: 1 host, 5 token\n"
    )


def test_a_free_port_and_a_chosen_one(tmp_path):
    with serving(tmp_path / "a", "--host", "localhost") as first:
        port = first.host.rpartition(":")[2]
        assert len(first.get("tasks.json")) >= 97
        start = time.monotonic()
        second = serving(tmp_path / "b", "--port", port)
        with pytest.raises(AssertionError, match=f"--port {port}"), second:
            pass
        assert time.monotonic() - start < SECONDS
