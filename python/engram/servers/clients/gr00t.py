"""GR00T: msgpack over ZeroMQ, one request after the other."""

from __future__ import annotations

import asyncio
import errno
from typing import Any

import numpy as np

from engram.servers.clients.connection import Connection, Question, api_key
from engram.servers.codecs import pack_gr00t, unpack_gr00t
from engram.servers.limits import ANSWER, OPENING, CodecError, TooLargeError
from engram.servers.zmtp import Wire, ZmtpError


class Gr00tConnection(Connection):
    """Endpoints ping, reset and get_action; B is 1."""

    _wire: Wire | None = None

    async def _connect(self) -> None:
        await self.close()
        ends = await asyncio.open_connection(self.options.host, self.options.port)
        self._wire = Wire(*ends, b"REQ", ANSWER)
        try:
            await asyncio.wait_for(self._wire.open(), OPENING)
        except ZmtpError as error:
            raise self.fail(f"does not speak gr00t: {error}") from None
        except EOFError:  # as of a server that begins or ends
            raise ConnectionResetError("closed during the handshake") from None
        except asyncio.TimeoutError:
            raise TimeoutError(errno.ETIMEDOUT, "no handshake") from None
        self.metadata = await self._call("ping", None)

    async def begin(self, env_id: str) -> None:
        if self.options.reset != "none" and not self.keys.flat:
            await self._call("reset", {"options": {"session_id": self.session}})

    async def ask(self, question: Question) -> Any:
        answer = await self._call("get_action", self._asked(question))
        if isinstance(answer, (list, tuple)) and answer:
            answer = answer[0]
        if not isinstance(answer, dict):
            return self.joined(answer, self.keys.actions)
        parts = {str(name).removeprefix("action."): part for name, part in answer.items()}
        if self.keys.flat and len(self.keys.actions) > 1:  # (T) or (T, D)
            parts = {
                n: self.numbers(p)[:, None] if np.ndim(p) == 1 else p for n, p in parts.items()
            }
        return self.joined(parts, self.keys.actions)

    def _asked(self, question: Question) -> dict[str, Any]:
        extras = {**self.keys.extra, **question.extras}

        def rows(values: Any, prefix: str = "") -> dict[str, Any]:  # (B, T, ...) or, flat, (T, ...)
            axes = (0, 1)[: (not self.keys.flat) + (not question.has_time)]
            return {prefix + name: np.expand_dims(value, axes) for name, value in values.items()}

        if self.keys.flat:
            video, state = rows(question.images, "video."), rows(question.state, "state.")
            return {**video, **state, self.keys.prompt: [question.prompt], **extras}
        observation = {
            "video": rows(question.images),
            "state": rows(question.state),
            "language": {self.keys.prompt: [[question.prompt]]},
        }
        return {"observation": observation, "options": {"session_id": self.session, **extras}}

    async def _call(self, endpoint: str, data: Any) -> Any:
        assert self._wire is not None
        request: dict[str, Any] = {"endpoint": endpoint}
        if data is not None:
            request["data"] = data
        key = api_key()
        if key:
            request["api_token"] = key
        await self.require_silence(self._wire.wait)
        try:
            await self._wire.write(pack_gr00t(request))
            body = await self._wire.read()
        except TooLargeError:
            raise self.too_large() from None
        except (ZmtpError, CodecError) as error:
            raise self.fail(f"answered with {error}") from None
        except (OSError, EOFError):
            raise self.lost("closed the connection before its answer was complete") from None
        result = await self.decoded(unpack_gr00t, body)
        if isinstance(result, dict) and "error" in result:
            raise self.reported(result["error"])
        return result

    async def close(self) -> None:
        if self._wire is not None:
            self._wire.close()
            self._wire = None
