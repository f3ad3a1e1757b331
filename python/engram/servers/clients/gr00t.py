"""GR00T: msgpack over ZeroMQ, one request after the other."""

from __future__ import annotations

import asyncio
import contextlib
import errno
from typing import Any

import numpy as np
import zmq
import zmq.asyncio
from zmq.utils.monitor import parse_monitor_message

from engram.servers.clients.connection import Connection, Question, api_key
from engram.servers.codecs import LARGEST, CodecError, pack_gr00t, unpack_gr00t
from engram.servers.options import bracketed

_GONE, _REFUSED = zmq.EVENT_DISCONNECTED, zmq.EVENT_CLOSED
_WATCHED = zmq.EVENT_CONNECTED | _GONE | _REFUSED


class Gr00tConnection(Connection):
    """Endpoints ping, reset and get_action; B is 1.

    ZeroMQ itself connects again and says nothing, so its monitor is watched: a question to a server
    that has ended would be waited for in vain.
    """

    _socket: zmq.asyncio.Socket | None = None
    _events: zmq.asyncio.Socket | None = None

    async def _connect(self) -> None:
        await self.close()
        self._socket = zmq.asyncio.Context.instance().socket(zmq.REQ)
        self._socket.setsockopt(zmq.LINGER, 0)
        self._socket.setsockopt(zmq.MAXMSGSIZE, LARGEST)
        self._socket.setsockopt(zmq.IPV6, 1)
        self._events = self._socket.get_monitor_socket(_WATCHED)
        host = bracketed(self.options.host)
        self._socket.connect(f"tcp://{host}:{self.options.port}")
        if await self._event() != zmq.EVENT_CONNECTED:
            raise ConnectionRefusedError(errno.ECONNREFUSED, "nobody listens")
        await self._call("ping", None)

    async def begin(self, env_id: str) -> None:
        if self.options.reset != "none":
            await self._call("reset", {"options": {"session_id": self.session}})

    async def ask(self, question: Question) -> Any:
        def rows(values: Any) -> dict[str, Any]:  # (B, T, ...)
            axes = (0,) if question.has_time else (0, 1)
            return {name: np.expand_dims(value, axes) for name, value in values.items()}

        observation = {
            "video": rows(question.images),
            "state": rows(question.state),
            "language": {self.keys.prompt: [[question.prompt]]},
        }
        options = {"session_id": self.session, **self.keys.extra, **question.extras}
        answer = await self._call("get_action", {"observation": observation, "options": options})
        if isinstance(answer, (list, tuple)) and answer:
            answer = answer[0]
        if not isinstance(answer, dict):
            return self.joined(answer, self.keys.actions)
        parts = {str(name).removeprefix("action."): part for name, part in answer.items()}
        return self.joined(parts, self.keys.actions)

    async def _event(self) -> int:
        assert self._events is not None
        return int(parse_monitor_message(await self._events.recv_multipart())["event"])

    async def _ended(self) -> None:
        """Returns when the connection has ended."""
        while await self._event() != _GONE:
            pass

    async def _call(self, endpoint: str, data: Any) -> Any:
        assert self._socket is not None
        request: dict[str, Any] = {"endpoint": endpoint}
        if data is not None:
            request["data"] = data
        key = api_key()
        if key:
            request["api_token"] = key
        await self._socket.send(pack_gr00t(request))
        answer, end = asyncio.ensure_future(self._socket.recv()), asyncio.create_task(self._ended())
        try:
            await asyncio.wait({answer, end}, return_when=asyncio.FIRST_COMPLETED)
            if not answer.done():
                raise self.lost(
                    "closed the connection before its answer was complete, or answered with more "
                    f"than {LARGEST >> 20} MiB"
                )
            body = answer.result()
        finally:
            answer.cancel()
            end.cancel()
        try:
            result = unpack_gr00t(body)
        except CodecError as error:
            raise self.fail(f"answered with {error}") from None
        if isinstance(result, dict) and "error" in result:
            raise self.reported(result["error"])
        return result

    async def close(self) -> None:
        socket, self._socket, self._events = self._socket, None, None
        if socket is not None:
            with contextlib.suppress(zmq.ZMQError):
                socket.disable_monitor()
            socket.close(linger=0)
