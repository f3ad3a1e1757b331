"""OpenVLA and servers like it: JSON with arrays over HTTP POST /act."""

from __future__ import annotations

import asyncio
import contextlib
from typing import Any

import aiohttp

from engram.servers.clients.connection import Connection, Question, api_key
from engram.servers.codecs import pack_json, unpack_json
from engram.servers.limits import ANSWER
from engram.servers.options import bracketed

_SLICE = 1 << 20


class ActConnection(Connection):
    """A request for every question; an episode is named by session_id."""

    _http: aiohttp.ClientSession | None = None
    _episode = 0

    async def _connect(self) -> None:
        await self.close()
        # Whether a server listens: HTTP itself connects with the first question.
        _, writer = await asyncio.open_connection(self.options.host, self.options.port)
        writer.close()
        with contextlib.suppress(OSError):
            await writer.wait_closed()
        self._http = aiohttp.ClientSession(
            connector=aiohttp.TCPConnector(force_close=True),  # kept ones end unasked
            timeout=aiohttp.ClientTimeout(total=None),
            auto_decompress=False,
        )

    async def begin(self, env_id: str) -> None:
        self._episode += 1

    async def ask(self, question: Question) -> Any:
        body = {
            **question.images,
            **question.state,
            self.keys.prompt: question.prompt,
            **self.keys.extra,
            **question.extras,
            "session_id": f"{self.session}-{self._episode}",
        }
        answer = await self._post(pack_json(body))
        if isinstance(answer, str):
            if answer == "error":
                raise self.reported("error, and says no more")
            answer = await self.decoded(unpack_json, answer.encode(errors="replace"))  # twice
        if isinstance(answer, dict):
            if "error" in answer:
                raise self.reported(answer["error"])
            names = self.keys.actions
            if names == ("actions",) and "action" in answer and "actions" not in answer:
                names = ("action",)
            return self.joined(answer, names)
        return answer

    async def _post(self, body: bytes) -> Any:
        assert self._http is not None
        host = bracketed(self.options.host)
        url = f"http://{host}:{self.options.port}{self.options.path or '/act'}"
        headers = {"Content-Type": "application/json"}
        key = api_key()
        if key:
            headers["Authorization"] = f"Api-Key {key}"
        try:
            async with self._http.post(
                url, data=body, headers=headers, allow_redirects=False
            ) as response:
                answer = bytearray()
                async for part in response.content.iter_chunked(_SLICE):
                    answer += part
                    if len(answer) > ANSWER:
                        raise self.too_large()
                status = response.status
        except aiohttp.ClientPayloadError:
            raise self.lost("closed the connection before its answer was complete") from None
        except aiohttp.ClientResponseError as error:
            raise self.fail(f"does not speak HTTP: {error.message}") from None
        except (aiohttp.ClientError, OSError) as error:
            raise self.lost(f"closed the connection: {error}") from None
        if status != 200:
            words = bytes(answer[:2000]).decode(errors="replace")
            raise self.reported(f"status {status} {' '.join(words.split())}")
        return await self.decoded(unpack_json, bytes(answer))

    async def close(self) -> None:
        if self._http is not None:
            await self._http.close()
            self._http = None
