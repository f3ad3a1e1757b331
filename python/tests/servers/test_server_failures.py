"""Servers that lie, stall, answer nonsense or die: one sentence, nothing lost, --resume goes on."""

from __future__ import annotations

import asyncio
import json
import socket
import time
from typing import Any

import numpy as np
import pytest
from policy_servers import (
    TASK,
    http_server,
    in_thread,
    observation,
    openpi_server,
    run_engram,
    socket_server,
    zmq_server,
)

import engram
from engram.servers import ServerError, ServerPolicy, codecs
from engram.servers.codecs import pack_gr00t, pack_json, pack_openpi

GOOD = np.zeros((2, 7), np.float32)


def refused(url: str, **options: Any) -> str:
    """The sentence of a failure."""
    options.setdefault("timeout", 20.0)
    policy = ServerPolicy(url, wait=1, **options)
    with pytest.raises(ServerError) as caught:
        policy(observation())
    policy.close()
    sentence = str(caught.value)
    assert sentence.startswith(f"policy server {url} ")
    assert "\n" not in sentence
    assert len(sentence) < 400
    return sentence.removeprefix(f"policy server {url} ")


# --- answers that no policy gives ---

NAN = GOOD.copy()
NAN[1, 2] = np.nan
ANSWERS = {
    "a value that is not finite": (NAN, "answered with nan in component 2 of action 1, a finite"),
    "an infinite one": (np.full((2, 7), 1e300), "answered with inf in component 0 of action 0"),
    "too many numbers": (np.zeros((4, 8)), "actions of shape (4, 8), (K, 7) or (7) needed"),
    "a batch": (np.zeros((2, 4, 7)), "actions of shape (2, 4, 7), (K, 7) or (7) needed"),
    "nothing": (np.zeros((0, 7)), "actions of shape (0, 7), (K, 7) or (7) needed"),
    "a number": (0.5, "actions of shape (), (K, 7) or (7) needed"),
    "too long a chunk": (np.zeros((1001, 7)), "actions of shape (1001, 7)"),
    "words": ("left a bit", "answered with the text 'left a bit', an array of numbers needed"),
    "no numbers": (None, "answered with a NoneType, an array of numbers needed"),
    "flags": (np.zeros((2, 7), bool), "answered with an array of bool"),
    "ragged lists": ([[0.0] * 7, [0.0]], "an array of numbers needed"),
}


@pytest.mark.parametrize(
    ("protocol", "case"),
    [
        (protocol, case)
        for protocol in ("openpi", "gr00t", "act")
        for case in ANSWERS
        if (protocol, case) != ("act", "words")  # a text is decoded again there
    ],
)
def test_bad_actions(protocol, case):
    value, words = ANSWERS[case]
    if protocol == "openpi":
        with openpi_server(lambda _: value) as url:
            assert words in refused(url)
    elif protocol == "gr00t":

        async def respond(message: bytes) -> bytes:
            good = b"get_action" not in message
            return pack_gr00t({} if good else [{"action": value}, {}])

        with zmq_server(respond) as url:
            assert words in refused(url)
    else:
        from aiohttp import web

        async def answer(_request: Any) -> Any:
            return web.Response(body=pack_json({"actions": value}))

        with http_server(answer) as url:
            assert words in refused(url)


def test_a_chunk_that_is_shorter_than_what_is_used():
    with openpi_server(lambda _: GOOD) as url:
        assert refused(url, replan=4) == "answered with 2 actions; --replan 4 needs as many"


MESSAGES = {
    "a text": ("Traceback\n  line\nValueError: no such key\n", "reports: ValueError: no such key"),
    "an empty text": ("", "reports: a failure without words"),
    "no msgpack": (b"\xc1\xc1", "answered with 2 bytes that are no msgpack"),
    "half a map": (pack_openpi({"actions": GOOD})[:-9], "that are no msgpack"),
    "no map": (pack_openpi([1, 2]), "answered with a list, a map with actions needed"),
    "another map": (pack_openpi({"action": 1, "x": 2}), "answered with action, x; actions needed"),
    "a deep one": (b"\x91" * 100_000, "answered with maps and lists more than 32 deep"),
    "an array that lies": (
        pack_openpi({"actions": {b"__ndarray__": True, b"data": b"1234", b"dtype": "<f4",
                                 b"shape": [1 << 40, 7]}}),
        "answered with an array of shape [1099511627776, 7], type <f4 and 4 bytes",
    ),
    "an array of objects": (
        pack_openpi({"actions": {b"__ndarray__": True, b"data": b"12345678", b"dtype": "|O",
                                 b"shape": [1]}}),
        "answered with an array of type '|O'",
    ),
    "an error": (pack_openpi({"error": "out of memory"}), "reports: out of memory"),
}  # fmt: skip


@pytest.mark.parametrize("case", MESSAGES)
def test_bad_messages(case):
    message, words = MESSAGES[case]

    async def talk(socket: Any) -> None:
        async for _ in socket:
            await socket.send(message)

    with socket_server(talk) as url:
        assert words in refused(url)


def test_bad_npy_arrays():
    """np.load would believe their headers."""
    good = pack_gr00t([{"action": GOOD}, {}])
    shape, order = b"(2, 7)", b"False"
    for old, new, words in (
        (shape, b"(9, 7)", "answered with an array of shape [9, 7]"),
        (b"<f4", b"|O8", "answered with an array of type '|O8'"),
        (order, b"Frlse", "answered with an array whose header cannot be read"),
        (b"\x93NUMPY", b"\x93NUMPX", "answered with an array that np.save did not write"),
    ):
        bad = good.replace(old, new)
        assert bad != good

        async def respond(message: bytes, bad: bytes = bad) -> bytes:
            return bad if b"get_action" in message else pack_gr00t({})

        with zmq_server(respond) as url:
            assert words in refused(url)


def test_mutated_messages_are_refused_or_read():
    """Whatever comes, it is a value or a CodecError; memory is not allocated by announcements."""
    rng = np.random.default_rng(5)
    value = {"actions": GOOD, "more": [GOOD[0], {"text": "x" * 30}, 1.5, None]}
    npy = np.asfortranarray(np.arange(6.0).reshape(2, 3))
    for pack, read in (
        (codecs.pack_openpi, codecs.unpack),
        (codecs.pack_vla_eval, codecs.unpack),
        (codecs.pack_gr00t, codecs.unpack_gr00t),
        (codecs.pack_json, codecs.unpack_json),
    ):
        good = pack({**value, "npy": npy})
        sentences = []
        for _ in range(4000):
            bad = bytearray(good[: rng.integers(1, len(good))] if rng.random() < 0.2 else good)
            for at in rng.integers(0, len(bad), rng.integers(1, 5)):
                bad[at] = rng.choice((0, 0x7F, 0xFF, 0xC0, 0xDF, rng.integers(256)))
            try:
                read(bytes(bad))
            except codecs.CodecError as error:
                sentences.append(str(error))
        assert len(sentences) > 400
        assert max(map(len, sentences)) < 300


# --- answers that do not end ---


def test_a_server_that_stalls():
    async def stall(_: Any) -> Any:
        await asyncio.sleep(4)

    for server in (socket_server, http_server, zmq_server):
        begin = time.monotonic()
        with server(stall) as url:
            assert refused(url, timeout=1.0) == "has not answered within 1 s"
        assert time.monotonic() - begin < 15


def test_a_gigabyte_over_a_socket():
    """Its announcement is enough."""

    async def talk(socket: Any) -> None:
        async for _ in socket:
            head = bytes([0x82, 127]) + (1 << 30).to_bytes(8, "big")
            socket.transport.write(head + bytes(1 << 20))

    with socket_server(talk) as url:
        assert refused(url) == "answered with more than 64 MiB"


def test_a_gigabyte_over_http():
    from aiohttp import web

    sent = 0

    async def respond(request: Any) -> Any:
        nonlocal sent
        response = web.StreamResponse(headers={"Content-Length": str(1 << 30)})
        await response.prepare(request)
        for _ in range(1024):
            await response.write(bytes(1 << 20))
            sent += 1
        return response

    with http_server(respond) as url:
        assert refused(url) == "answered with more than 64 MiB"
    assert sent < 200


def test_too_much_over_zmq():
    async def respond(message: bytes) -> bytes:
        return bytes(80 << 20) if b"get_action" in message else pack_gr00t({})

    with zmq_server(respond) as url:
        assert refused(url) == "answered with more than 64 MiB"


def test_half_a_message():
    async def talk(socket: Any) -> None:
        async for _ in socket:
            socket.transport.write(bytes([0x82, 126]) + (1000).to_bytes(2, "big") + bytes(10))
            socket.transport.close()

    with socket_server(talk) as url:
        assert refused(url) == "closed the connection before its answer was complete"


def test_half_a_response():
    from aiohttp import web

    async def respond(request: Any) -> Any:
        response = web.StreamResponse(headers={"Content-Length": "1000"})
        await response.prepare(request)
        await response.write(b"[1, 2")
        request.transport.close()
        return response

    with http_server(respond) as url:
        assert refused(url) == "closed the connection before its answer was complete"


def test_an_http_failure():
    from aiohttp import web

    async def respond(_request: Any) -> Any:
        return web.Response(status=500, text="CUDA out of memory\n")

    with http_server(respond) as url:
        assert refused(url) == "reports: status 500 CUDA out of memory"


def test_others_than_policy_servers():
    """A port at which something else listens."""

    async def run(ready: Any) -> None:
        async def greet(reader: Any, writer: Any) -> None:
            writer.write(b"SSH-2.0-OpenSSH_9.2\r\n")
            await writer.drain()
            await reader.read()
            writer.close()

        async with await asyncio.start_server(greet, "127.0.0.1", 0) as server:
            ready(server.sockets[0].getsockname()[1])
            await server.serve_forever()

    with in_thread(run) as port:
        assert "does not speak openpi" in refused(f"openpi://127.0.0.1:{port}")
        assert "does not speak HTTP" in refused(f"act://127.0.0.1:{port}")
        assert refused(f"gr00t://127.0.0.1:{port}", timeout=3.0)


def test_nobody_listens():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        port = one.getsockname()[1]
    for protocol in ("openpi", "gr00t", "act", "vla-eval"):
        words = refused(f"{protocol}://127.0.0.1:{port}")
        assert words == "cannot be reached within 1 s: Connection refused"


# --- connections that end ---


def test_a_lost_connection_is_made_again_where_nothing_can_be_forgotten():
    """In the first question of an episode, and with reset=none in every one."""
    talks = 0

    async def talk(socket: Any) -> None:
        nonlocal talks
        talks += 1
        if talks == 1:
            return  # before any answer
        async for _ in socket:
            await socket.send(pack_openpi({"actions": GOOD}))
            if talks == 2:
                return  # after the first answer

    with socket_server(talk) as url:
        policy = ServerPolicy(url, reset="none")
        for step in range(3):
            assert policy(observation(step=step))[0].shape == (2, 7)
        assert talks == 3
        policy.close()
        talks = 1
        policy = ServerPolicy(url)
        policy(observation())
        with pytest.raises(ServerError, match="may have forgotten the first 1 questions"):
            policy(observation(step=2))
        with pytest.raises(ServerError, match="was left in this episode"):
            policy(observation(step=4))
        policy(observation())  # the next episode
        policy.close()


def test_a_server_that_listens_later():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        port = one.getsockname()[1]

    async def run(ready: Any) -> None:
        from websockets.asyncio.server import serve

        async def talk(socket: Any) -> None:
            await socket.send(pack_openpi({}))
            async for _ in socket:
                await socket.send(pack_openpi({"actions": GOOD}))

        ready(port)
        await asyncio.sleep(1)
        async with serve(talk, "127.0.0.1", port) as server:
            await server.serve_forever()

    with in_thread(run):
        policy = ServerPolicy(f"openpi://127.0.0.1:{port}", wait=15)
        assert policy(observation())[0].shape == (2, 7)
        policy.close()


TASKS = ("RememberColor5-VLA-v0", TASK)


def swaying(request: dict[str, Any]) -> np.ndarray:
    """Actions as a function of what is seen."""
    light = request["observation/image"].mean() + request["observation/state"].sum()
    return 0.3 * np.sin(light * np.arange(1, 8)) * np.ones((5, 1))


@pytest.mark.parametrize("how", ["dies", "lies"])
def test_resume_goes_on_after_a_failure(how, tmp_path):
    """A server that fails in an episode of the second task: the first one's results are kept."""
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        port = one.getsockname()[1]
    questions = 0

    def server(fails: bool) -> Any:
        from websockets.asyncio.server import serve

        from engram.servers.codecs import unpack

        async def talk(socket: Any) -> None:
            nonlocal questions
            await socket.send(pack_openpi({}))
            async for message in socket:
                questions += 1
                if fails and questions > 5 * 3 + 7:
                    if how == "dies":
                        await socket.close()
                        return
                    await socket.send(pack_openpi({"actions": NAN}))
                    continue
                await socket.send(pack_openpi({"actions": swaying(unpack(message))}))

        async def run(ready: Any) -> None:
            async with serve(talk, "127.0.0.1", port, max_size=None) as server:
                ready(port)
                await server.serve_forever()

        return in_thread(run)

    words = ["--policy-server", f"openpi://127.0.0.1:{port}", "--threads", "1", "--num-envs", "1"]
    begin = ["eval", *TASKS, "--episodes", "3", *words]
    with server(fails=True):
        done = run_engram(*begin, "--out", str(tmp_path / "a"))
    assert done.returncode == 1
    assert done.stderr.startswith(f"engram: policy server openpi://127.0.0.1:{port} ")
    assert done.stderr.count("\n") == 1, done.stderr
    (folder,) = (tmp_path / "a" / "short").iterdir()
    first = sorted(folder.glob("*-VLA-v0.json"))
    assert len(first) == 1
    kept = first[0].read_bytes()
    questions = 0
    with server(fails=False):
        done = run_engram("eval", "--resume", str(folder), *words)
        assert done.returncode == 0, done.stderr
        assert questions == 5 * 2  # of the second task, whose first episode is kept
        assert first[0].read_bytes() == kept
        done = run_engram(*begin, "--out", str(tmp_path / "b"))
        assert done.returncode == 0, done.stderr
    (whole,) = (tmp_path / "b" / "short").iterdir()
    for file in ("summary.json", *(f"{task}.json" for task in TASKS)):
        assert json.loads((folder / file).read_text()) == json.loads((whole / file).read_text())


def test_evaluate_raises_the_sentence(tmp_path):
    with openpi_server(lambda _: NAN) as url, pytest.raises(ServerError, match="finite number"):
        engram.evaluate(url, TASK, episodes=2, output=tmp_path)
    assert not list(tmp_path.rglob("*-VLA-v0.json"))
