"""WebSockets of openpi's and vla-eval's protocols."""

from __future__ import annotations

import contextlib
from typing import Any

import numpy as np
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake

from engram.servers.clients.connection import Connection, Question, api_key
from engram.servers.codecs import pack_openpi, pack_vla_eval, unpack
from engram.servers.limits import ANSWER, OPENING, SIDE
from engram.servers.options import bracketed

_TOO_BIG = 1009  # code of a close


class _Connect(connect):
    """Connects to the named server alone."""

    def process_redirect(self, exc: Exception) -> Exception:
        return exc


class _Socket(Connection):
    """Messages over a WebSocket, without compression.

    Without pings as well: a server that compiles for minutes answers none.
    """

    _socket: ClientConnection | None = None

    async def _open_socket(self) -> None:
        key = api_key()
        host = bracketed(self.options.host)
        try:
            self._socket = await _Connect(
                f"ws://{host}:{self.options.port}{self.options.path}",
                compression=None,
                max_size=ANSWER,
                ping_interval=None,
                open_timeout=OPENING,
                close_timeout=1,
                proxy=None,
                additional_headers={"Authorization": f"Api-Key {key}"} if key else None,
            )
        except InvalidHandshake as error:
            raise self.fail(f"does not speak {self.options.protocol}: {error}") from None
        except EOFError:  # closed during the handshake, as a server does that begins or ends
            raise ConnectionResetError("closed during the handshake") from None

    async def _exchange(self, message: bytes) -> Any:
        await self._send(message)
        return await self._receive()

    async def _send(self, message: bytes) -> None:
        assert self._socket is not None
        try:
            await self._socket.send(message)
        except ConnectionClosed as error:
            raise self._closed(error) from None

    async def _receive(self, acknowledgement: str = "") -> Any:
        """A message, unpacked; a text is a failure, unless it begins with the acknowledgement."""
        assert self._socket is not None
        try:
            answer = await self._socket.recv()
        except ConnectionClosed as error:
            raise self._closed(error) from None
        if isinstance(answer, str):
            if acknowledgement and answer.startswith(acknowledgement):
                return answer
            raise self.reported(answer)
        return await self.decoded(unpack, answer)

    def _closed(self, error: ConnectionClosed) -> Exception:
        sent, received = error.sent, error.rcvd
        if sent is not None and sent.code == _TOO_BIG and not error.rcvd_then_sent:
            return self.too_large()
        if received is None:
            return self.lost("closed the connection before its answer was complete")
        reason = f": {received.reason}" if received.reason else ""
        return self.lost(f"closed the connection (code {received.code}{reason})")

    async def close(self) -> None:
        if self._socket is not None:
            with contextlib.suppress(Exception):
                await self._socket.close()
            self._socket = None


class OpenpiConnection(_Socket):
    """One msgpack map for every question. The server begins with its metadata.

    That of RoboArena's servers has more: they want an endpoint and a session in every message, and
    answer with the array alone.
    """

    _arena = False
    _episode = 0

    async def _send(self, message: bytes) -> None:
        assert self._socket is not None
        await self.require_silence(self._socket.recv)
        await super()._send(message)

    async def finish(self) -> None:
        assert self._socket is not None
        await self.require_silence(self._socket.recv)
        await super().finish()

    async def _connect(self) -> None:
        await self._open_socket()
        metadata = await self._receive()
        if not isinstance(metadata, dict):
            raise self.fail("does not begin with its metadata, a map")
        self.metadata = metadata
        self._arena = "needs_session_id" in metadata
        size = metadata.get("image_resolution")
        if self.options.image is None and isinstance(size, (list, tuple)) and len(size) == 2:
            if not all(type(side) is int and 8 <= side <= SIDE for side in size):
                raise self.fail(
                    f"asks for images of {size!r:.60}; [height, width] from 8 to {SIDE} needed, "
                    "--server-image chooses another size"
                )
            self.size = (size[0], size[1])
        space = metadata.get("action_space")
        if isinstance(space, str) and "joint" in space and not self.keys.needs_joints:
            raise self.fail(f"acts in {space!r:.40}, and policies act on the TCP's pose here")

    async def begin(self, env_id: str) -> None:
        self._episode += 1
        if self.options.reset == "message":
            message = {"endpoint": "reset", "reset": True, **self._arena_keys("reset")}
            await self._send(pack_openpi(message))
            answer = await self._receive(acknowledgement="reset")
            if isinstance(answer, dict) and "error" in answer:
                raise self.reported(answer["error"])

    async def ask(self, question: Question) -> Any:
        message = {
            **question.images,
            **question.state,
            self.keys.prompt: question.prompt,
            **self.keys.extra,
            **question.extras,
            **self._arena_keys("infer"),
        }
        answer = await self._exchange(pack_openpi(message))
        if self._arena and isinstance(answer, np.ndarray):
            return answer
        if isinstance(answer, dict) and "error" in answer:
            raise self.reported(answer["error"])
        return self.joined(answer, self.keys.actions)

    def _arena_keys(self, endpoint: str) -> dict[str, str]:
        if not self._arena:
            return {}
        return {"endpoint": endpoint, "session_id": f"{self.session}-{self._episode}"}


class VlaEvalConnection(_Socket):
    """Numbered messages {type, payload, seq, timestamp}."""

    _number = 0
    _in_episode = False

    async def _connect(self) -> None:
        await self._open_socket()
        self._in_episode = False
        hello = {"harness_version": "engram", "protocol_version": 1}
        self.metadata = await self._ask("hello", hello, "hello")

    async def begin(self, env_id: str) -> None:
        if self._in_episode:
            await self._send(self._message("episode_end", {}))
        await self._send(self._message("episode_start", {"task": {"name": env_id}}))
        self._in_episode = True

    async def ask(self, question: Question) -> Any:
        observation = {
            "images": dict(question.images),
            **question.state,
            self.keys.prompt: question.prompt,
            **self.keys.extra,
            **question.extras,
        }
        return self.joined(await self._ask("observation", observation, "action"), self.keys.actions)

    def _message(self, kind: str, payload: dict[str, Any]) -> bytes:
        self._number += 1
        return pack_vla_eval(
            {"type": kind, "payload": payload, "seq": self._number, "timestamp": 0.0}
        )

    async def _ask(self, kind: str, payload: dict[str, Any], expected: str) -> Any:
        answer = await self._exchange(self._message(kind, payload))
        if not isinstance(answer, dict) or not isinstance(answer.get("payload"), dict):
            raise self.fail("answered with something else than a message of vla-eval")
        found, body = answer.get("type"), answer["payload"]
        if found == "error":
            raise self.reported(body.get("error", body))
        if found != expected or answer.get("seq") != self._number:
            raise self.fail(
                f"answered with message {found!r:.40} {answer.get('seq')!r:.20}, {expected} "
                f"{self._number} needed"
            )
        return body
