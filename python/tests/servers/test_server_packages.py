"""Released servers of the protocols, and plain ones, against our client."""

from __future__ import annotations

import asyncio
import json
import threading
from typing import Any

import numpy as np
import pytest
from policy_servers import (
    decode_npy,
    encode_npy,
    http_server,
    in_thread,
    observation,
    zmq_server,
)

from engram.servers import ServerError, ServerPolicy
from engram.servers.frames import resize


class Recorder:
    """A policy of openpi's kind."""

    def __init__(self) -> None:
        self.seen: list[dict[str, Any]] = []

    def infer(self, obs: dict[str, Any]) -> dict[str, Any]:
        if obs["prompt"] == "fail":
            raise ValueError("image of the\nwrong kind")
        self.seen.append(obs)
        return {"actions": np.tile(np.arange(7.0), (10, 1))}

    def reset(self) -> None:
        pass


@pytest.mark.parametrize("package", ["openpi_server", "policy_websocket"])
def test_openpi_servers(package):
    server_class = pytest.importorskip(package).WebsocketPolicyServer
    policy = Recorder()

    async def run(ready):
        server = server_class(policy, host="127.0.0.1", port=0, metadata={"name": "theirs"})
        # Its own `run` does not tell the port: the same handler, at one that we know.
        from websockets.asyncio.server import serve

        async with serve(server._handler, "127.0.0.1", 0, compression=None, max_size=None) as bound:
            ready(next(iter(bound.sockets)).getsockname()[1])
            await bound.serve_forever()

    with in_thread(run) as port:
        client = ServerPolicy(f"openpi://127.0.0.1:{port}", keys="libero", replan=4)
        seen = observation(2)
        chunks = client(seen)
        assert [chunk.shape for chunk in chunks] == [(4, 7)] * 2
        got = policy.seen[0]
        assert set(got) == {
            "observation/image",
            "observation/wrist_image",
            "observation/state",
            "prompt",
        }
        assert got["observation/image"].shape == (224, 224, 3)
        assert got["observation/wrist_image"].dtype == np.uint8
        assert got["observation/state"].shape == (8,)
        assert got["prompt"] == "touch it"
        with pytest.raises(ServerError, match=r"reports: wrong kind$"):
            client(observation(instruction=["fail"]))
        client.close()


def test_a_server_like_those_of_roboarena():
    """They want an endpoint and a session in every message, and answer with the array alone."""
    from websockets.asyncio.server import serve

    from engram.servers.codecs import pack_openpi, unpack

    seen: list[dict[str, Any]] = []

    async def talk(socket: Any) -> None:
        config = {"image_resolution": [64, 64], "needs_wrist_camera": True}
        await socket.send(pack_openpi({**config, "needs_session_id": True}))
        async for message in socket:
            seen.append(unpack(message))
            if seen[-1]["endpoint"] == "reset":
                await socket.send("reset successful")
            else:
                await socket.send(pack_openpi(np.ones((5, 7), np.float32)))

    async def run(ready):
        async with serve(talk, "127.0.0.1", 0) as server:
            ready(next(iter(server.sockets)).getsockname()[1])
            await server.serve_forever()

    with in_thread(run) as port:
        client = ServerPolicy(f"openpi://127.0.0.1:{port}", reset="message")
        for step in (0, 5, 0):
            assert client(observation(step=step))[0].shape == (5, 7)
        client.close()
    assert [one["endpoint"] for one in seen] == ["reset", "infer", "infer", "reset", "infer"]
    sessions = [one["session_id"] for one in seen]
    assert len(set(sessions)) == 2
    assert sessions[0] == sessions[1] == sessions[2]
    assert seen[1]["observation/image"].shape == (64, 64, 3)


def test_pictures_are_resized_as_by_openpi():
    tools = pytest.importorskip("openpi_client.image_tools")
    rng = np.random.default_rng(3)
    for shape, size in (
        ((128, 128), (224, 224)),
        ((128, 128), (180, 320)),
        ((90, 160), (224, 224)),
        ((200, 100), (64, 96)),
    ):
        picture = rng.integers(0, 256, (2, *shape, 3), np.uint8)
        assert np.array_equal(resize(picture, size), tools.resize_with_pad(picture, *size))


def test_a_server_of_json_numpy():
    json_numpy = pytest.importorskip("json_numpy")
    from aiohttp import web

    bodies: list[Any] = []

    async def respond(request):
        bodies.append(json_numpy.loads(await request.text()))
        kind = bodies[-1]["instruction"]
        answer: Any = [np.arange(7, dtype=np.float64)] * 8
        if kind == "one":
            answer = np.arange(7.0)
        if kind == "twice":
            answer = json_numpy.dumps(np.arange(7.0))
        if kind == "error":
            answer = "error"
        return web.Response(text=json_numpy.dumps(answer), content_type="application/json")

    with http_server(respond) as url:
        client = ServerPolicy(url, keys="openvla", actions="mikasa")
        assert client(observation())[0].shape == (8, 7)
        assert client(observation(instruction=["one"]))[0].tolist() == [list(range(7))]
        assert client(observation(instruction=["twice"]))[0].tolist() == [list(range(7))]
        with pytest.raises(ServerError, match="reports: error, and says no more"):
            client(observation(instruction=["error"]))
        assert set(bodies[0]) == {"image", "instruction", "session_id"}
        assert bodies[0]["image"].shape == (224, 224, 3)
        assert bodies[0]["session_id"] != bodies[1]["session_id"]  # another episode
        client.close()
        client = ServerPolicy(url, keys="oft")
        client(observation())
        assert {"full_image", "wrist_image", "state"} < set(bodies[-1])
        client.close()


def test_a_server_of_plain_zmq():
    import msgpack

    seen: list[Any] = []

    async def respond(message: bytes) -> bytes:
        request = msgpack.unpackb(message, object_hook=decode_npy)
        seen.append(request)
        answer: Any = {}
        if request["endpoint"] == "get_action":
            parts = ("x", "y", "z", "roll", "pitch", "yaw", "gripper")
            answer = [
                {f"action.{name}": np.full((1, 16, 1), i / 20) for i, name in enumerate(parts)},
                {},
            ]
        return bytes(msgpack.packb(answer, default=encode_npy))

    with zmq_server(respond) as url:
        client = ServerPolicy(url, keys="libero", actions="mikasa", history="2,1")
        actions = client(observation())[0]
        assert np.allclose(actions, np.arange(7) / 20)
        assert [request["endpoint"] for request in seen] == ["ping", "reset", "get_action"]
        data = seen[-1]["data"]["observation"]
        assert data["video"]["image"].shape == (1, 2, 256, 256, 3)
        assert data["state"]["gripper"].shape == (1, 2, 2)
        assert data["language"] == {"annotation.human.action.task_description": [["touch it"]]}
        client.close()


def test_a_server_of_flat_keys():
    """GR00T N1.5: no batch, no endpoint for a new episode."""
    import msgpack

    seen: list[Any] = []

    async def respond(message: bytes) -> bytes:
        request = msgpack.unpackb(message, object_hook=decode_npy)
        seen.append(request)
        answer: Any = {}
        if request["endpoint"] == "get_action":
            parts = ("x", "y", "z", "roll", "pitch", "yaw", "gripper")
            answer = {f"action.{name}": np.full(16, i / 20) for i, name in enumerate(parts)}
        return bytes(msgpack.packb(answer, default=encode_npy))

    with zmq_server(respond) as url:
        client = ServerPolicy(url, keys="n1.5-libero", actions="mikasa")
        assert np.allclose(client(observation())[0], np.arange(7) / 20)
        client.close()
        client = ServerPolicy(url, keys="n1.5-libero", history="3,1")
        client(observation())
        client.close()
    assert [request["endpoint"] for request in seen] == ["ping", "get_action"] * 2
    shapes = {name: np.shape(value) for name, value in seen[1]["data"].items()}
    axes = dict.fromkeys(
        (f"state.{name}" for name in ("x", "y", "z", "roll", "pitch", "yaw")), (1, 1)
    )
    assert shapes == {
        **axes,
        "state.gripper": (1, 2),
        "video.image": (1, 256, 256, 3),
        "video.wrist_image": (1, 256, 256, 3),
        "annotation.human.action.task_description": (1,),
    }
    assert seen[3]["data"]["video.image"].shape == (3, 256, 256, 3)


def test_the_server_of_vla_eval():
    serving = pytest.importorskip("vla_eval.model_servers.serve")
    import anyio
    from vla_eval.model_servers.predict import PredictModelServer

    class Pusher(PredictModelServer):
        def __init__(self) -> None:
            super().__init__()
            self.seen: list[dict[str, Any]] = []

        def predict(self, obs, ctx):
            self.seen.append({**obs, "is_first": ctx.is_first})
            if obs["task_description"] == "fail":
                raise ValueError("no such task")
            return {"actions": np.asarray(obs["state"])}

    server = Pusher()

    async def run(ready):
        async with anyio.create_task_group() as group:
            ready(await group.start(serving.serve_async, server, "127.0.0.1", 0))

    with in_thread(run) as port:
        client = ServerPolicy(f"vla-eval://127.0.0.1:{port}")
        for step in (0, 1, 0):
            seen = observation(step=step)
            assert np.array_equal(client(seen)[0][0], seen["proprio"][0])
        assert [obs["is_first"] for obs in server.seen] == [True, False, True]
        assert server.seen[0]["images"]["base_camera"].shape == (128, 128, 3)
        with pytest.raises(ServerError, match="no such task"):
            client(observation(instruction=["fail"]))
        client.close()


def test_codecs_are_those_of_the_packages():
    """Bytes that one writes are read by the other."""
    openpi = pytest.importorskip("openpi_client.msgpack_numpy")
    json_numpy = pytest.importorskip("json_numpy")
    from engram.servers import codecs

    value = {
        "a": np.arange(6, dtype=np.uint8).reshape(2, 3),
        "b": [np.float32(1.5), "text", None],
        "c": np.zeros((0, 7), np.float32),
        "d": np.asfortranarray(np.arange(6.0).reshape(2, 3)),
    }
    for pack, read in (
        (codecs.pack_openpi, openpi.unpackb),
        (openpi.packb, codecs.unpack),
        (codecs.pack_json, json_numpy.loads),
        (lambda v: json_numpy.dumps(v).encode(), codecs.unpack_json),
        (codecs.pack_gr00t, codecs.unpack_gr00t),
    ):
        again = read(pack(value))
        assert again["b"][1:] == ["text", None]
        assert float(again["b"][0]) == 1.5
        for name in "acd":
            assert np.array_equal(again[name], value[name])
            assert again[name].dtype == value[name].dtype


def test_pings_of_a_server_are_answered_while_the_simulator_works():
    """Nothing is asked for a while, and the connection holds."""
    from websockets.asyncio.server import serve

    from engram.servers.codecs import pack_openpi

    talks = []

    async def talk(socket: Any) -> None:
        talks.append(socket)
        await socket.send(pack_openpi({}))
        async for _ in socket:
            await socket.send(pack_openpi({"actions": np.zeros((1, 7))}))

    async def run(ready):
        async with serve(talk, "127.0.0.1", 0, ping_interval=0.1, ping_timeout=0.2) as server:
            ready(next(iter(server.sockets)).getsockname()[1])
            await server.serve_forever()

    with in_thread(run) as port:
        client = ServerPolicy(f"openpi://127.0.0.1:{port}")
        client(observation())
        threading.Event().wait(1)
        client(observation(step=1))
        assert len(talks) == 1
        client.close()


def test_a_key_for_the_server(monkeypatch):
    from websockets.asyncio.server import serve

    from engram.servers.codecs import pack_openpi

    async def talk(socket: Any) -> None:
        key = socket.request.headers.get("Authorization")
        await socket.send(pack_openpi({}))
        async for _ in socket:
            await socket.send(pack_openpi({"actions": np.full((1, 7), len(key or ""))}))

    async def run(ready):
        async with serve(talk, "127.0.0.1", 0) as server:
            ready(next(iter(server.sockets)).getsockname()[1])
            await server.serve_forever()

    monkeypatch.setenv("ENGRAM_SERVER_KEY", "secret")
    with in_thread(run) as port:
        client = ServerPolicy(f"openpi://127.0.0.1:{port}")
        assert client(observation())[0][0, 0] == len("Api-Key secret")
        assert "secret" not in json.dumps(client.config)
        client.close()


def test_threads_may_call_at_the_same_time():
    """Several episodes in flight: questions wait for the server together."""
    from engram.servers.codecs import pack_openpi

    waiting = 0
    most = 0

    async def talk(socket: Any) -> None:
        nonlocal waiting, most
        await socket.send(pack_openpi({}))
        async for _ in socket:
            waiting += 1
            most = max(most, waiting)
            await asyncio.sleep(0.2)
            waiting -= 1
            await socket.send(pack_openpi({"actions": np.zeros((1, 7))}))

    async def run(ready):
        from websockets.asyncio.server import serve

        async with serve(talk, "127.0.0.1", 0) as server:
            ready(next(iter(server.sockets)).getsockname()[1])
            await server.serve_forever()

    with in_thread(run) as port:
        client = ServerPolicy(f"openpi://127.0.0.1:{port}")
        threads = [
            threading.Thread(target=client, args=(observation(3, worker=worker),))
            for worker in range(2)
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert most == 6
        client.close()
