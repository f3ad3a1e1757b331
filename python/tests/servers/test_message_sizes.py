"""Sizes of messages at their limit and one byte beyond, in both directions of every protocol.

The limits are smaller here than the real ones, so that no test needs hundreds of megabytes.
"""

from __future__ import annotations

import contextlib
import functools
import http.client
from collections.abc import Callable, Iterator
from typing import Any

import fuzz_wires
import numpy as np
import pytest
from policy_servers import http_server, in_thread, observation, socket_server, zmq_server
from test_server_failures import refused
from websockets.exceptions import ConnectionClosedError
from websockets.sync.client import connect

from engram.servers import ServerPolicy, limits
from engram.servers.clients import act, gr00t, sockets
from engram.servers.codecs import pack_gr00t, pack_json, pack_openpi, unpack, unpack_gr00t
from engram.servers.keys import keys_of
from engram.servers.serving import protocols
from engram.servers.serving.policies import ServedPolicy
from engram.servers.serving.reading import Reader

LIMIT = 200_000  # bytes
PAD = LIMIT // 2  # msgpack has one form for its length and that of all paddings here
GOOD = np.zeros((1, 7), np.float32)


def padded(size: int, whole: Callable[[bytes], bytes]) -> bytes:
    """A message of that many bytes, most of them padding."""
    message = whole(bytes(size - len(whole(bytes(PAD))) + PAD))
    assert len(message) == size
    return message


# --- answers of servers ---


@contextlib.contextmanager
def openpi_answers(size: int) -> Iterator[str]:
    message = padded(size, lambda pad: pack_openpi({"actions": GOOD, "more": pad}))

    async def talk(socket: Any) -> None:
        async for _ in socket:
            await socket.send(message)

    with socket_server(talk) as url:
        yield url


@contextlib.contextmanager
def gr00t_answers(size: int) -> Iterator[str]:
    message = padded(size, lambda pad: pack_gr00t([{"action": GOOD}, {"more": pad}]))

    async def respond(question: bytes) -> bytes:
        return message if b"get_action" in question else pack_gr00t({})

    with zmq_server(respond) as url:
        yield url


@contextlib.contextmanager
def act_answers(size: int) -> Iterator[str]:
    from aiohttp import web

    async def respond(_request: Any) -> Any:
        return web.Response(body=pack_json(GOOD).ljust(size))

    with http_server(respond) as url:
        yield url


ANSWERS = {
    "openpi": (sockets, openpi_answers),
    "gr00t": (gr00t, gr00t_answers),
    "act": (act, act_answers),
}


@pytest.mark.parametrize("protocol", ANSWERS)
def test_an_answer_at_the_limit_and_one_byte_more(protocol, monkeypatch):
    module, answers = ANSWERS[protocol]
    monkeypatch.setattr(module, "ANSWER", LIMIT)
    with answers(LIMIT) as url:
        policy = ServerPolicy(url, wait=5, timeout=20)
        assert policy(observation())[0].shape == (1, 7)
        policy.close()
    with answers(LIMIT + 1) as url:
        assert refused(url) == "answered with more than 64 MiB"


# --- requests to `engram serve` ---


class Still(ServedPolicy):
    def answer(self, request: Any) -> Any:
        return GOOD


def asked_openpi(port: int, size: int) -> str:
    state = np.zeros((1, 7), np.float32)
    question = padded(
        size, lambda pad: pack_openpi({"observation/state": state, "prompt": "", "more": pad})
    )
    with connect(f"ws://127.0.0.1:{port}", proxy=None) as client:
        client.recv()
        client.send(question)
        try:
            answer = client.recv(timeout=20)
        except ConnectionClosedError as error:
            return f"closed with {error.rcvd.code if error.rcvd else None}"
        return "answered" if "actions" in unpack(answer) else str(answer)


def asked_gr00t(port: int, size: int) -> str:
    import zmq

    with zmq.Context() as context, context.socket(zmq.REQ) as client:
        client.setsockopt(zmq.LINGER, 0)
        client.setsockopt(zmq.RCVTIMEO, 20_000)
        client.connect(f"tcp://127.0.0.1:{port}")
        client.send(padded(size, lambda pad: pack_gr00t({"endpoint": "ping", "more": pad})))
        answer = unpack_gr00t(client.recv())
        return "answered" if answer.get("status") == "ok" else answer["error"]


def asked_act(port: int, size: int) -> str:
    body = pack_json({"observation/state": np.zeros((1, 7)), "instruction": ""}).ljust(size)
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=20)
    connection.request("POST", "/act", body, {"Content-Type": "application/json"})
    answer = connection.getresponse().read()
    connection.close()
    return "answered" if b"error" not in answer else answer.decode()


REQUESTS = {
    "openpi": (protocols.serve_openpi, asked_openpi, "closed with 1009"),
    "gr00t": (protocols.serve_gr00t, asked_gr00t, "a request of more than"),
    "act": (protocols.serve_act, asked_act, "a request of more than"),
}


@pytest.mark.parametrize("protocol", REQUESTS)
def test_a_request_at_the_limit_and_one_byte_more(protocol, monkeypatch):
    serve, ask, words = REQUESTS[protocol]
    monkeypatch.setattr(limits, "REQUEST", LIMIT)
    reader = Reader(Still(), keys_of(protocol, "mikasa"))
    with in_thread(functools.partial(serve, reader, "127.0.0.1", 0)) as port:
        assert ask(port, LIMIT) == "answered"
        assert words in ask(port, LIMIT + 1)


@pytest.mark.parametrize("name", [*fuzz_wires.READERS, *fuzz_wires.SERVERS])
def test_a_slice_of_the_fuzzed_bytes(name):
    longest, findings = fuzz_wires.play(name, 0, 50)
    assert findings == []
    assert longest < 5
