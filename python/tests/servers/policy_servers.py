"""Servers for tests: engram's own in a process, scripted ones in a thread."""

from __future__ import annotations

import asyncio
import contextlib
import io
import json
import subprocess
import sys
import threading
from collections.abc import Awaitable, Callable, Iterator
from typing import Any

import numpy as np

TASK = "RememberColor3-VLA-v0"


@contextlib.contextmanager
def engram_serve(*words: str) -> Iterator[str]:
    """The command `engram serve` at a free port; yields its URL."""
    command = [sys.executable, "-m", "engram", "serve", "--port", "0", *words]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            line = process.stdout.readline()
            assert line.startswith("engram serve: "), line
            yield line.removeprefix("engram serve: ").strip()
        finally:
            process.terminate()


def run_engram(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "engram", *words], capture_output=True, text=True, check=False
    )


def results_of(*words: str) -> Any:
    done = run_engram(*words, "--json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def without_name(results: Any) -> str:
    """Results as text, without what names the policy."""
    for task in results["tasks"]:
        for key in ("model", "tell_episodes", "checksum"):
            task.pop(key, None)
    return json.dumps(results)


@contextlib.contextmanager
def in_thread(serve: Callable[[Callable[[int], None]], Awaitable[None]]) -> Iterator[int]:
    """Runs a server until the end of the block; yields the port that it reports."""
    loop, ports, bound = asyncio.new_event_loop(), [], threading.Event()

    def ready(port: int) -> None:
        ports.append(port)
        bound.set()

    async def main() -> None:
        with contextlib.suppress(asyncio.CancelledError):
            await serve(ready)

    task = loop.create_task(main())
    thread = threading.Thread(target=loop.run_until_complete, args=(task,))
    thread.start()
    assert bound.wait(20)
    try:
        yield ports[0]
    finally:
        loop.call_soon_threadsafe(task.cancel)
        thread.join(20)
        loop.close()


@contextlib.contextmanager
def socket_server(talk: Callable[[Any], Awaitable[None]]) -> Iterator[str]:
    """A WebSocket server with that conversation, after openpi's metadata."""
    from websockets.asyncio.server import serve
    from websockets.exceptions import ConnectionClosed

    from engram.servers.codecs import pack_openpi

    async def greet_and_talk(socket: Any) -> None:
        with contextlib.suppress(ConnectionClosed):
            await socket.send(pack_openpi({}))
            await talk(socket)

    async def run(ready: Callable[[int], None]) -> None:
        async with serve(greet_and_talk, "127.0.0.1", 0, compression=None, max_size=None) as server:
            ready(next(iter(server.sockets)).getsockname()[1])
            await server.serve_forever()

    with in_thread(run) as port:
        yield f"openpi://127.0.0.1:{port}"


@contextlib.contextmanager
def openpi_server(act: Callable[[dict[str, Any]], Any]) -> Iterator[str]:
    """Answers maps with act(map) as actions."""
    from engram.servers.codecs import pack_openpi, unpack

    async def talk(socket: Any) -> None:
        async for message in socket:
            await socket.send(pack_openpi({"actions": act(unpack(message))}))

    with socket_server(talk) as url:
        yield url


@contextlib.contextmanager
def http_server(respond: Callable[[Any], Awaitable[Any]]) -> Iterator[str]:
    """POST /act, answered by respond(request)."""
    from aiohttp import web

    async def run(ready: Callable[[int], None]) -> None:
        app = web.Application(client_max_size=1 << 28)
        app.router.add_post("/act", respond)
        runner = web.AppRunner(app, access_log=None, shutdown_timeout=0.1)
        await runner.setup()
        await web.TCPSite(runner, "127.0.0.1", 0).start()
        ready(runner.addresses[0][1])
        try:
            await asyncio.Event().wait()
        finally:
            await runner.cleanup()

    with in_thread(run) as port:
        yield f"act://127.0.0.1:{port}"


@contextlib.contextmanager
def zmq_server(respond: Callable[[bytes], Awaitable[bytes | None]]) -> Iterator[str]:
    """A REP socket, answered by respond(request); None ends the server."""
    import zmq
    import zmq.asyncio

    async def run(ready: Callable[[int], None]) -> None:
        with zmq.asyncio.Context() as context, context.socket(zmq.REP) as socket:
            socket.setsockopt(zmq.LINGER, 0)
            ready(socket.bind_to_random_port("tcp://127.0.0.1"))
            while (answer := await respond(await socket.recv())) is not None:
                await socket.send(answer)

    with in_thread(run) as port:
        yield f"gr00t://127.0.0.1:{port}"


# NumPy's arrays in msgpack, as Isaac-GR00T has them.
def encode_npy(value: Any) -> Any:
    file = io.BytesIO()
    np.save(file, value, allow_pickle=False)
    return {"__ndarray_class__": True, "as_npy": file.getvalue()}


def decode_npy(value: Any) -> Any:
    if "__ndarray_class__" in value:
        return np.load(io.BytesIO(value["as_npy"]), allow_pickle=False)
    return value


def observation(count: int = 1, step: int = 0, first: bool | None = None, **more: Any) -> Any:
    """An observation of engram.evaluate, made up."""
    rng = np.random.default_rng(7 + step)
    return {
        "env_id": TASK,
        "worker": 0,
        "slot": np.arange(count, dtype=np.int32),
        "episode": np.arange(count, dtype=np.int32),
        "step": np.full(count, step, np.int32),
        "first": np.full(count, (step == 0) if first is None else first, np.uint8),
        "instruction": ["touch it"] * count,
        "proprio": rng.normal(size=(count, 7)).astype(np.float32),
        "rgb": rng.integers(0, 256, (count, 128, 128, 6), np.uint8),
        "state": None,
        **more,
    }
