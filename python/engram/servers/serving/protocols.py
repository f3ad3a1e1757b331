"""The servers' side of the protocols. Policies are computed one at a time."""

from __future__ import annotations

import asyncio
import contextlib
import http
from typing import Any

import numpy as np

from engram.errors import Error
from engram.servers.codecs import (
    CodecError,
    pack_gr00t,
    pack_json,
    pack_openpi,
    unpack,
    unpack_gr00t,
    unpack_json,
)
from engram.servers.serving.reading import Reader

_LARGEST = 256 << 20  # bytes of a request


def _sentence(error: Exception) -> str:
    """Failure of a request, in words for its client."""
    if isinstance(error, (Error, CodecError)):
        return str(error)
    return f"{type(error).__name__}: {error}"


async def serve_openpi(reader: Reader, host: str, port: int, ready: Any) -> None:
    """WebSockets; a connection is a session, and so is what follows a reset."""
    from websockets.asyncio.server import ServerConnection, serve
    from websockets.exceptions import ConnectionClosed

    async def talk(socket: ServerConnection, session: int) -> None:
        await socket.send(pack_openpi({"server": "engram", "image_resolution": reader.keys.size}))
        async for message in socket:
            try:
                request = unpack(message if isinstance(message, bytes) else message.encode())
                if not isinstance(request, dict):
                    raise CodecError("a request that is no map")
                if request.get("endpoint") == "reset" or request.get("reset") is True:
                    reader.sessions.begin(session)
                    await socket.send(pack_openpi({"reset_finished": True}))
                    continue
                prompt = request.get(reader.keys.prompt)
                episode = request.get("engram")
                actions = reader.answer(session, request, request, prompt, episode)
            except Exception as error:
                await socket.send(_sentence(error))
                await socket.close(1011, "the last message has the reason")
                return
            await socket.send(pack_openpi({"actions": actions}))

    async def talk_until_closed(socket: ServerConnection) -> None:
        session = reader.sessions.new()
        with contextlib.suppress(ConnectionClosed):
            await talk(socket, session)
        reader.sessions.end(session)

    def healthy(connection: ServerConnection, request: Any) -> Any:
        if request.path == "/healthz":
            return connection.respond(http.HTTPStatus.OK, "OK\n")
        return None

    async with serve(
        talk_until_closed,
        host,
        port,
        compression=None,
        max_size=_LARGEST,
        ping_interval=None,
        process_request=healthy,
    ) as server:
        ready(next(iter(server.sockets)).getsockname()[1])
        await server.serve_forever()


async def serve_gr00t(reader: Reader, host: str, port: int, ready: Any) -> None:
    """ZeroMQ; options may name the session."""
    import zmq
    import zmq.asyncio

    socket = zmq.asyncio.Context.instance().socket(zmq.REP)
    socket.setsockopt(zmq.MAXMSGSIZE, _LARGEST)
    where = f"tcp://{host}"
    if port:
        socket.bind(f"{where}:{port}")
    else:
        port = socket.bind_to_random_port(where)
    ready(port)
    while True:
        message = await socket.recv()
        try:
            answer: Any = _answer_gr00t(reader, unpack_gr00t(message))
        except Exception as error:
            answer = {"error": _sentence(error)}
        await socket.send(pack_gr00t(answer))


def _answer_gr00t(reader: Reader, request: Any) -> Any:
    if not isinstance(request, dict):
        raise CodecError("a request that is no map")
    endpoint, data = request.get("endpoint"), request.get("data") or {}
    options = data.get("options") if isinstance(data, dict) else None
    options = options if isinstance(options, dict) else {}
    session = reader.sessions.of(options.get("session_id"))
    if endpoint == "ping":
        return {"status": "ok", "message": "Server is running"}
    if endpoint == "reset":
        reader.sessions.begin(session)
        return {}
    if endpoint != "get_action":
        raise CodecError(f"endpoint {endpoint!r:.40}; ping, reset and get_action allowed")
    seen = data.get("observation") if isinstance(data, dict) else None
    parts = [seen.get(name) for name in _MODALITIES] if isinstance(seen, dict) else []
    maps = [part for part in parts if isinstance(part, dict)]
    if len(maps) != len(_MODALITIES):
        raise CodecError("an observation without video, state or language")
    video, state, language = maps
    words = np.ravel(language.get(reader.keys.prompt, [""]))
    actions = reader.answer(
        session, _first(video), _first(state), str(words[0]), options.get("engram")
    )
    names = reader.keys.actions
    widths = [1] * (len(names) - 1)
    pieces = np.split(actions[None], np.cumsum(widths), -1) if widths else [actions[None]]
    return [dict(zip(names, pieces)), {}]


_MODALITIES = ("video", "state", "language")


def _first(arrays: dict[str, Any]) -> dict[str, Any]:
    """Arrays without the batch's axis, which has to be one long."""
    result = {}
    for name, array in arrays.items():
        if not isinstance(array, np.ndarray) or array.ndim < 2 or len(array) != 1:
            raise CodecError(f"{name}: an array (1, T, ...) needed, one episode at a time")
        result[name] = array[0]
    return result


async def serve_act(reader: Reader, host: str, port: int, ready: Any) -> None:
    """HTTP; session_id may name the episode."""
    from aiohttp import web

    async def act(request: web.Request) -> web.Response:
        try:
            body = unpack_json(await request.read())
            if isinstance(body, dict) and isinstance(body.get("encoded"), str):
                body = unpack_json(body["encoded"])
            if not isinstance(body, dict):
                raise CodecError("a request that is no object")
            session = reader.sessions.of(body.get("session_id"))
            episode = body.get("engram")
            actions = reader.answer(session, body, body, body.get(reader.keys.prompt), episode)
        except Exception as error:
            return _json({"error": _sentence(error)})
        return _json(actions[0] if len(actions) == 1 else list(actions))

    def _json(value: Any) -> web.Response:
        return web.Response(body=pack_json(value), content_type="application/json")

    async def healthy(_request: web.Request) -> web.Response:
        return web.Response(text="OK\n")

    app = web.Application(client_max_size=_LARGEST)
    app.router.add_post("/act", act)
    app.router.add_get("/healthz", healthy)
    runner = web.AppRunner(app, access_log=None, handle_signals=False)
    await runner.setup()
    site = web.TCPSite(runner, host, port)
    await site.start()
    ready(runner.addresses[0][1])
    await asyncio.Event().wait()


SERVERS = {"openpi": serve_openpi, "gr00t": serve_gr00t, "act": serve_act}
