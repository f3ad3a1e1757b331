"""The servers' side of the protocols. Policies are computed one at a time."""

from __future__ import annotations

import asyncio
import contextlib
import http
from collections.abc import Mapping
from typing import Any

import numpy as np

import engram
from engram.errors import Error
from engram.servers import limits
from engram.servers.codecs import (
    pack_gr00t,
    pack_json,
    pack_openpi,
    unpack,
    unpack_gr00t,
    unpack_json,
)
from engram.servers.hosts import OwnNames
from engram.servers.limits import CodecError
from engram.servers.serving.reading import Reader
from engram.servers.zmtp import Wire, ZmtpError

_TOO_MANY_BYTES = "too many requests wait for their answers"


def _sentence(error: Exception) -> str:
    """Failure of a request, in words for its client."""
    if isinstance(error, limits.TooLargeError):
        return f"a request of more than {limits.REQUEST >> 20} MiB"
    if isinstance(error, (Error, CodecError)):
        return str(error)
    return f"{type(error).__name__}: {error}"[: limits.WORDS]


def _identity(reader: Reader) -> dict[str, Any]:
    return {"server": "engram", "version": engram.__version__, **reader.policy.identity}


def _refusal(headers: Mapping[str, str], names: OwnNames) -> str | None:
    """Why a request may be a page's; clients that are programs send none of this."""
    if "Origin" in headers or headers.get("Sec-Fetch-Site", "none") != "none":
        return "refused: sent by a page of a browser\n"
    if not names.everywhere and headers.get("Host", "") not in names:
        return "refused: the server does not have that name\n"
    return None


async def serve_openpi(reader: Reader, host: str, port: int, ready: Any) -> None:
    """WebSockets; a connection is a session, and so is what follows a reset."""
    from websockets.asyncio.server import ServerConnection, serve
    from websockets.exceptions import ConnectionClosed

    traffic, names = limits.Traffic(), OwnNames(host)

    class Client(ServerConnection):
        """A connection whose bytes are counted as they come."""

        def connection_made(self, transport: asyncio.BaseTransport) -> None:
            super().connection_made(transport)
            if not traffic.enter(self):
                self.transport.abort()

        def data_received(self, data: bytes) -> None:
            if traffic.receive(self, len(data)):
                super().data_received(data)
            else:
                self.transport.abort()

        def connection_lost(self, exc: Exception | None) -> None:
            traffic.leave(self)
            super().connection_lost(exc)

    async def answered(session: int, message: bytes | str) -> Any:
        data = message if isinstance(message, bytes) else message.encode()
        request = await limits.decoded(unpack, data)
        if not isinstance(request, dict):
            raise CodecError("a request that is no map")
        if request.get("endpoint") == "reset" or request.get("reset") is True:
            reader.sessions.begin(session)
            return {"reset_finished": True}
        prompt, episode = request.get(reader.keys.prompt), request.get("engram")
        return {"actions": await reader.answer(session, request, request, prompt, episode)}

    async def talk(socket: ServerConnection, session: int) -> None:
        told = {**_identity(reader), "image_resolution": reader.keys.size}
        await socket.send(pack_openpi(told))
        async for message in socket:
            try:
                answer = await answered(session, message)
            except Exception as error:
                await socket.send(_sentence(error))
                await socket.close(1011, "the last message has the reason")
                return
            traffic.answer(socket, len(message))
            await socket.send(pack_openpi(answer))

    async def talk_until_closed(socket: ServerConnection) -> None:
        session = reader.sessions.new()
        with contextlib.suppress(ConnectionClosed):
            await talk(socket, session)
        reader.sessions.end(session)

    def checked(connection: ServerConnection, request: Any) -> Any:
        refusal = _refusal(request.headers, names)
        if refusal is not None:
            return connection.respond(http.HTTPStatus.FORBIDDEN, refusal)
        if request.path == "/healthz":
            return connection.respond(http.HTTPStatus.OK, "OK\n")
        return None

    async with serve(
        talk_until_closed,
        host,
        port,
        compression=None,
        max_size=limits.REQUEST,
        max_queue=1,
        open_timeout=limits.OPENING,
        ping_interval=None,
        process_request=checked,
        create_connection=Client,
    ) as server:
        ready(next(iter(server.sockets)).getsockname()[1])
        await server.serve_forever()


async def serve_gr00t(reader: Reader, host: str, port: int, ready: Any) -> None:
    """ZeroMQ; options may name the session."""
    traffic = limits.Traffic()

    async def talk(ends: tuple[asyncio.StreamReader, asyncio.StreamWriter]) -> None:
        unanswered = 0

        def receive(count: int) -> None:
            nonlocal unanswered
            unanswered += count
            if not traffic.receive(ends, count):
                raise OSError(_TOO_MANY_BYTES)

        wire = Wire(*ends, b"REP", limits.REQUEST, receive)
        await asyncio.wait_for(wire.open(), limits.OPENING)
        while True:
            try:
                answer = await _answer_gr00t(reader, await wire.read())
            except (OSError, EOFError, ZmtpError):
                return
            except Exception as error:
                answer = {"error": _sentence(error)}
                if isinstance(error, limits.TooLargeError):
                    await wire.write(pack_gr00t(answer))
                    return
            traffic.answer(ends, unanswered)
            unanswered = 0
            await wire.write(pack_gr00t(answer))

    async def talk_until_closed(*ends: Any) -> None:
        lost = (OSError, EOFError, ZmtpError, asyncio.TimeoutError)
        if traffic.enter(ends):
            with contextlib.suppress(*lost):
                await talk(ends)
        traffic.leave(ends)
        ends[1].close()

    async with await asyncio.start_server(talk_until_closed, host, port) as server:
        ready(server.sockets[0].getsockname()[1])
        await server.serve_forever()


async def _answer_gr00t(reader: Reader, message: bytes) -> Any:
    request = await limits.decoded(unpack_gr00t, message)
    if not isinstance(request, dict):
        raise CodecError("a request that is no map")
    endpoint, data = request.get("endpoint"), request.get("data") or {}
    options = data.get("options") if isinstance(data, dict) else None
    options = options if isinstance(options, dict) else {}
    session = reader.sessions.of(options.get("session_id"))
    if endpoint == "ping":
        return {"status": "ok", "message": "Server is running", **_identity(reader)}
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
    actions = await reader.answer(
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

    traffic, names = limits.Traffic(), OwnNames(host)

    async def body_of(request: web.Request, client: object) -> bytes:
        body = bytearray()
        async for part in request.content.iter_any():
            body += part
            if len(body) > limits.REQUEST:
                raise limits.TooLargeError
            if not traffic.receive(client, len(part)):
                raise CodecError(_TOO_MANY_BYTES)
        return bytes(body)

    async def actions_of(body: Any) -> Any:
        if isinstance(body, dict) and isinstance(body.get("encoded"), str):
            body = await limits.decoded(unpack_json, body["encoded"].encode(errors="replace"))
        if not isinstance(body, dict):
            raise CodecError("a request that is no object")
        session = reader.sessions.of(body.get("session_id"))
        prompt, episode = body.get(reader.keys.prompt), body.get("engram")
        actions = await reader.answer(session, body, body, prompt, episode)
        return actions[0] if len(actions) == 1 else list(actions)

    async def act(request: web.Request) -> web.Response:
        refusal = _refusal(request.headers, names)
        if refusal is not None:
            raise web.HTTPForbidden(text=refusal)
        client = object()
        try:
            body = await body_of(request, client)
            answer = await actions_of(await limits.decoded(unpack_json, body))
        except Exception as error:
            answer = {"error": _sentence(error)}
        finally:
            traffic.leave(client)
        return web.Response(body=pack_json(answer), content_type="application/json")

    async def healthy(_request: web.Request) -> web.Response:
        return web.Response(text="OK\n")

    def client() -> asyncio.Protocol:
        full = len(runner.server.connections) >= limits.CLIENTS
        return _Refused() if full else runner.server()

    app = web.Application()
    app.router.add_post("/act", act)
    app.router.add_get("/healthz", healthy)
    runner: Any = web.AppRunner(
        app, access_log=None, handle_signals=False, auto_decompress=False, lingering_time=0
    )
    await runner.setup()
    async with await asyncio.get_running_loop().create_server(client, host, port) as server:
        ready(server.sockets[0].getsockname()[1])
        await server.serve_forever()


class _Refused(asyncio.Protocol):
    """A client of too many."""

    def connection_made(self, transport: Any) -> None:
        transport.abort()


SERVERS = {"openpi": serve_openpi, "gr00t": serve_gr00t, "act": serve_act}
