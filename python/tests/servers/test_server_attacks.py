"""Servers and clients that attack: what they send costs little, and is refused in one sentence."""

from __future__ import annotations

import asyncio
import contextlib
import http.client
import json
import socket
import struct
import threading
import time
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
import pytest
from policy_servers import (
    TASK,
    engram_serve,
    http_server,
    in_thread,
    observation,
    socket_server,
    zmq_server,
)
from test_server_failures import refused
from websockets.exceptions import InvalidStatus, WebSocketException
from websockets.sync.client import connect

from engram.servers import ServerPolicy
from engram.servers.codecs import pack_gr00t, pack_json, pack_openpi, unpack

GOOD = np.zeros((1, 7), np.float32)


@contextlib.contextmanager
def answering(message: bytes) -> Iterator[str]:
    """An openpi server with that answer to every question."""

    async def talk(socket: Any) -> None:
        async for _ in socket:
            await socket.send(message)

    with socket_server(talk) as url:
        yield url


# --- what a server answers ---


def black_png(side: int) -> bytes:
    """A picture of that size in a few kilobytes."""

    def chunk(kind: bytes, body: bytes) -> bytes:
        return (
            struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        )

    deflate = zlib.compressobj(9)
    row = bytes(1 + side)
    rows = b"".join(deflate.compress(row) for _ in range(side)) + deflate.flush()
    head = struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", rows) + chunk(b"IEND", b"")


def test_pictures_in_answers_are_not_decoded():
    picture = {"__image__": True, "format": "png", "data": black_png(6000)}
    with answering(pack_openpi({"actions": picture})) as url:
        assert refused(url) == "answered with a dict, an array of numbers needed"


def array_of(dtype: str) -> bytes:
    parts = {b"__ndarray__": True, b"data": b"", b"dtype": dtype, b"shape": [0]}
    return bytes(msgpack.packb({"actions": parts}))


COSTLY = {
    "a type of many fields": array_of("f8," * 300_000),
    "a type of many axes": array_of("(" + "1," * 500_000 + ")f8"),
    "empty lists": b"\x81\xa7actions\xdd" + struct.pack(">I", 4 << 20) + b"\x90" * (4 << 20),
    "empty maps": b"\x81\xa7actions\xdd" + struct.pack(">I", 4 << 20) + b"\x80" * (4 << 20),
    "lists in lists": b"\x91" * 1000 + b"\xc0",
    "a list that is announced": b"\xdd\xff\xff\xff\xff",
    "an extension": bytes(msgpack.packb({"actions": msgpack.ExtType(5, b"x")})),
}


@pytest.mark.parametrize("case", COSTLY)
def test_answers_that_cost_more_than_they_have_bytes(case):
    with answering(COSTLY[case]) as url:
        policy = ServerPolicy(url, wait=1, timeout=20)
        begin = time.monotonic()
        with pytest.raises(Exception, match="answered with") as caught:
            policy(observation())
        assert time.monotonic() - begin < 1
        assert len(str(caught.value)) < 300
        policy.close()


def test_json_of_empty_lists():
    from aiohttp import web

    async def respond(_request: Any) -> Any:
        return web.Response(body=b'{"actions": [' + b"[]," * 3_000_000 + b"[]]}")

    with http_server(respond) as url:
        assert refused(url) == "answered with a message of more than 100,000 values"


def test_an_answer_of_several_frames():
    """A socket of libzmq would store all of them."""
    import zmq
    import zmq.asyncio

    async def run(ready: Any) -> None:
        with zmq.asyncio.Context() as context, context.socket(zmq.REP) as replier:
            replier.setsockopt(zmq.LINGER, 0)
            ready(replier.bind_to_random_port("tcp://127.0.0.1"))
            while True:
                question = await replier.recv()
                parts = [pack_gr00t({})]
                if b"get_action" in question:
                    parts = [pack_gr00t([{"action": GOOD}, {}])] * 3
                await replier.send_multipart(parts)

    with in_thread(run) as port:
        words = refused(f"gr00t://127.0.0.1:{port}")
    assert words == "answered with a message of 3 frames, one needed"


def test_frames_without_end():
    """Each is small enough; together they are not, although the last one never comes."""
    ready = b"\x04\x19\x05READY\x0bSocket-Type\x00\x00\x00\x03REP"
    sent = 0

    async def greet(reader: Any, writer: Any) -> None:
        nonlocal sent
        writer.write(b"\xff" + bytes(8) + b"\x7f\x03\x00NULL" + bytes(16 + 32) + ready)
        await reader.readuntil(b"endpoint")  # a question
        frame = b"\x03" + struct.pack(">Q", 8 << 20) + bytes(8 << 20)
        with contextlib.suppress(ConnectionError):
            while sent < 1 << 30:
                writer.write(frame)
                sent += len(frame)
                await writer.drain()
        writer.close()

    async def run(bound: Any) -> None:
        async with await asyncio.start_server(greet, "127.0.0.1", 0) as server:
            bound(server.sockets[0].getsockname()[1])
            await server.serve_forever()

    with in_thread(run) as port:
        assert refused(f"gr00t://127.0.0.1:{port}") == "answered with more than 64 MiB"
    assert sent < 200 << 20


def test_two_answers_to_a_question():
    """The second one would be taken as that to the next question."""
    asked = 0

    async def talk(socket: Any) -> None:
        nonlocal asked
        async for _ in socket:
            asked += 1
            for part in range(2 if asked == 3 else 1):
                await socket.send(pack_openpi({"actions": GOOD + asked / 100 - part}))

    with socket_server(talk) as url:
        policy = ServerPolicy(url)
        actions = [policy(observation(step=step))[0][0, 0] for step in range(3)]
        assert np.allclose(actions, [0.01, 0.02, 0.03])
        time.sleep(0.1)
        with pytest.raises(Exception, match="answered twice; one answer to a question needed"):
            policy(observation(step=3))
        policy.close()


def test_redirects_are_not_followed():
    from aiohttp import web
    from websockets.asyncio.server import serve

    visited = 0

    async def visit(*_: Any) -> Any:
        nonlocal visited
        visited += 1
        return web.Response(body=pack_json({"actions": GOOD}))

    with http_server(visit) as other:
        place = other.replace("act:", "http:") + "/act"

        async def redirect(_request: Any) -> Any:
            return web.Response(status=307, headers={"Location": place})

        with http_server(redirect) as url:
            assert refused(url) == "reports: status 307"

        async def run(ready: Any) -> None:
            def redirected(connection: Any, _request: Any) -> Any:
                answer = connection.respond(302, "there\n")
                answer.headers["Location"] = place.replace("http:", "ws:")
                return answer

            async def talk(_socket: Any) -> None:
                pass

            async with serve(talk, "127.0.0.1", 0, process_request=redirected) as server:
                ready(next(iter(server.sockets)).getsockname()[1])
                await server.serve_forever()

        with in_thread(run) as port:
            words = refused(f"openpi://127.0.0.1:{port}")
            assert words.startswith("does not speak openpi: server rejected")
    assert visited == 0


def test_sizes_that_a_server_may_ask_for():
    from websockets.asyncio.server import serve

    def asking(size: list[int]) -> Any:
        async def talk(socket: Any) -> None:
            await socket.send(pack_openpi({"image_resolution": size}))
            async for message in socket:
                picture = unpack(message)["observation/image"]
                await socket.send(pack_openpi({"actions": np.full((1, 7), picture.shape[-2])}))

        async def run(ready: Any) -> None:
            async with serve(talk, "127.0.0.1", 0, max_size=None) as server:
                ready(next(iter(server.sockets)).getsockname()[1])
                await server.serve_forever()

        return in_thread(run)

    with asking([1024, 1024]) as port:
        url = f"openpi://127.0.0.1:{port}"
        policy = ServerPolicy(url)
        assert policy(observation())[0][0, 0] == 1024
        policy.close()
        words = refused(url, history="16,1")
        assert words.startswith(
            "asks for images of 1024 x 1024, with a history of 16 frames 96 MiB; 64"
        )
    with asking([1024, 1025]) as port:
        url = f"openpi://127.0.0.1:{port}"
        words = refused(url)
        assert words.startswith("asks for images of [1024, 1025]; [height, width] from 8 to 1024")
        policy = ServerPolicy(url, image="32")  # the caller's own choice
        assert policy(observation())[0][0, 0] == 32
        policy.close()


def test_failures_in_endless_words():
    for text in ("x" * (8 << 20), "\n" * (8 << 20), "a b " * (2 << 20)):

        async def talk(socket: Any, text: str = text) -> None:
            async for _ in socket:
                await socket.send(text)

        with socket_server(talk) as url:
            policy = ServerPolicy(url)
            with pytest.raises(Exception, match="reports: ") as caught:
                policy(observation())
            assert len(str(caught.value)) < 2200
            policy.close()


def test_a_server_that_ends_at_the_first_question():
    """As one does that does not know its keys: it was there."""

    async def respond(message: bytes) -> bytes | None:
        return None if b"get_action" in message else pack_gr00t({})

    with zmq_server(respond) as url:
        words = refused(url)
    assert words == (
        "cannot be reached within 1 s: Connection refused; it was there, and closed the connection "
        "after the first question"
    )


# --- what unauthenticated clients ask of `engram serve` ---

POLICY = """
import time
import numpy as np

def load(file):
    calls = 0

    def act(observation):
        nonlocal calls
        calls += 1
        time.sleep(0.001)
        return np.full((1, 1, 7), calls / 10000, np.float32)

    return act
"""


@pytest.fixture
def policy(tmp_path) -> list[str]:
    """Arguments of `engram serve`: a policy that counts its calls, of a millisecond each."""
    code = Path(tmp_path, "counting.py")
    code.write_text(POLICY)
    return ["--policy", "none", "--loader", f"{code}:load"]


def proprio(frames: int, key: str = "observation/state") -> dict[str, Any]:
    return {key: np.zeros((frames, 7), np.float32), "prompt": ""}


def test_a_request_of_many_frames(policy):
    with engram_serve(*policy) as url, connect(url.replace("openpi", "ws"), proxy=None) as client:
        client.recv()
        client.send(pack_openpi(proprio(1000)))
        assert unpack(client.recv(timeout=20))["actions"][0, 0] == np.float32(0.1)
        client.send(pack_openpi(proprio(1001)))
        answer = client.recv(timeout=20)
        assert answer.startswith("1001 frames given; the same number of images and states, 1 to")


def test_other_clients_are_served_while_a_policy_computes(policy):
    with engram_serve(*policy) as url:
        address = url.replace("openpi", "ws")
        with connect(address, proxy=None) as slow:
            slow.recv()
            slow.send(pack_openpi(proprio(1000)))
            begin = time.monotonic()
            with connect(address, proxy=None) as other:
                other.recv()
                assert time.monotonic() - begin < 0.7
            slow.recv(timeout=20)


@pytest.mark.parametrize("frames", [2, 100_000])
def test_a_request_of_several_frames(policy, frames):
    import zmq

    with (
        engram_serve(*policy, "--protocol", "gr00t") as url,
        zmq.Context() as context,
        context.socket(zmq.REQ) as client,
    ):
        client.setsockopt(zmq.LINGER, 0)
        client.setsockopt(zmq.RCVTIMEO, 20_000)
        client.connect(url.replace("gr00t", "tcp"))
        client.send_multipart([pack_gr00t({"endpoint": "ping"})] * frames)
        answer = msgpack.unpackb(client.recv())
        assert answer == {"error": f"a message of {frames} frames, one needed"}
        client.send(pack_gr00t({"endpoint": "ping"}))
        assert msgpack.unpackb(client.recv())["status"] == "ok"


def test_pictures_in_requests_are_not_decoded(policy):
    picture = {"__image__": True, "format": "png", "data": black_png(6000)}
    with engram_serve(*policy) as url, connect(url.replace("openpi", "ws"), proxy=None) as client:
        client.recv()
        client.send(pack_openpi({"observation/state": picture}))
        assert client.recv(timeout=20).startswith("observation/state: shape () given")


BROWSERS = (
    {"Origin": "https://evil.example"},
    {"Origin": "null"},
    {"Host": "evil.example"},
    {"Host": "evil.example:80"},
    {"Sec-Fetch-Site": "cross-site"},
)


@pytest.mark.parametrize("headers", BROWSERS)
def test_pages_of_browsers_are_refused(policy, headers):
    with engram_serve(*policy, "--protocol", "act") as url:
        where = url.removeprefix("act://")
        body = pack_json({"state": [0.0] * 7, "instruction": ""})

        def post(**headers: str) -> tuple[int, bytes]:
            connection = http.client.HTTPConnection(where, timeout=20)
            connection.request("POST", "/act", body, {"Content-Type": "text/plain", **headers})
            answer = connection.getresponse()
            return answer.status, answer.read()

        status, words = post(**headers)
        assert status == 403
        assert words.startswith(b"refused: ")
        assert post()[0] == 200
        assert post(Host="localhost:1")[0] == 200  # a tunnel's end
    with engram_serve(*policy) as url:
        more = {name: value for name, value in headers.items() if name != "Host"}
        place = url.removeprefix("openpi://").split(":")
        address = f"ws://{headers.get('Host', url.removeprefix('openpi://'))}/"
        with (
            socket.create_connection((place[0], int(place[1]))) as one,
            pytest.raises(InvalidStatus, match="403"),
        ):
            connect(address, sock=one, additional_headers=more, proxy=None)


def resident(url: str) -> int:
    """Bytes of memory of the process that listens there."""
    port = int(url.rpartition(":")[2])
    line = next(
        line.split()
        for line in Path("/proc/net/tcp").read_text().splitlines()[1:]
        if line.split()[1].endswith(f":{port:04X}") and line.split()[3] == "0A"
    )
    link = f"socket:[{line[9]}]"
    for folder in Path("/proc").glob("[0-9]*/fd"):
        with contextlib.suppress(OSError):
            if any(str(one.readlink()) == link for one in folder.iterdir()):
                words = (folder.parent / "status").read_text().split()
                return int(words[words.index("VmHWM:") + 1]) << 10
    raise AssertionError("nobody listens")


PIECE = bytes(1 << 20)
UNFINISHED = {
    "openpi": b"GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    b"Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n\r\n"
    b"\x82\xff" + struct.pack(">Q", 250 << 20) + bytes(4),
    "gr00t": b"\xff" + bytes(8) + b"\x7f\x03\x00NULL" + bytes(16 + 32)
    + b"\x04\x19\x05READY\x0bSocket-Type\x00\x00\x00\x03REQ\x01\x00\x02"
    + struct.pack(">Q", 250 << 20),
    "act": b"POST /act HTTP/1.1\r\nHost: localhost\r\nContent-Length: 262144000\r\n\r\n",
}  # fmt: skip


@pytest.mark.parametrize("protocol", UNFINISHED)
def test_unfinished_requests_are_counted_together(policy, protocol):
    """Six of 200 MiB: some are dropped, and the next client is served."""
    with engram_serve(*policy, "--protocol", protocol) as url:
        host, port = url.partition("://")[2].split(":")
        dropped, open_ones = 0, []
        for _ in range(6):
            one = socket.create_connection((host, int(port)), timeout=20)
            open_ones.append(one)
            try:
                one.sendall(UNFINISHED[protocol])
                for _ in range(200):
                    one.sendall(PIECE)
            except OSError:
                dropped += 1
        time.sleep(0.5)
        used = resident(url)
        assert used < 1100 << 20
        assert dropped >= 3
        for one in open_ones:
            one.close()
        time.sleep(0.5)
        client = ServerPolicy(url, timeout=20)
        assert client(observation())[0].shape == (1, 7)
        client.close()


def test_connections_are_counted(policy):
    with engram_serve(*policy) as url:
        host, port = url.partition("://")[2].split(":")
        idle = [socket.create_connection((host, int(port))) for _ in range(256)]
        time.sleep(0.5)
        with (
            pytest.raises((OSError, EOFError, WebSocketException)),
            connect(url.replace("openpi", "ws"), proxy=None, open_timeout=3),
        ):
            pass
        for one in idle:
            one.close()
        time.sleep(0.5)
        with connect(url.replace("openpi", "ws"), proxy=None) as client:
            client.recv()


def test_threads_ask_a_policy_one_at_a_time(policy):
    """Its calls are numbered without gaps."""
    with engram_serve(*policy, "--protocol", "act") as url:
        answers: list[float] = []

        def ask() -> None:
            client = ServerPolicy(url, timeout=20)
            for step in range(20):
                answers.append(client(observation(step=step))[0][0, 0])
            client.close()

        threads = [threading.Thread(target=ask) for _ in range(4)]
        for one in threads:
            one.start()
        for one in threads:
            one.join()
        assert np.allclose(sorted(answers), np.arange(1, 81) / 10000)


def test_sentences_of_refusals_are_short(policy):
    with engram_serve(*policy, "--protocol", "act") as url:
        connection = http.client.HTTPConnection(url.removeprefix("act://"), timeout=20)
        connection.request("POST", "/act", json.dumps({"engram": {"env_id": TASK * 100_000}}))
        answer = connection.getresponse().read()
        assert len(json.loads(answer)["error"]) < 2100
