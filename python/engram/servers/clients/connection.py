"""Interface of a connection, and what all of them send and read."""

from __future__ import annotations

import abc
import asyncio
import dataclasses
import os
from collections.abc import Callable, Coroutine, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from engram.errors import UnavailableError
from engram.servers import limits
from engram.servers.keys import Keys
from engram.servers.limits import CodecError
from engram.servers.options import ServerOptions

Array = npt.NDArray[Any]

_RETRY_SECONDS = 0.25


class ServerError(UnavailableError):
    """The server cannot be reached, is too slow, breaks the protocol or reports a failure."""


class LostError(ServerError):
    """The connection ended before an answer. Another one may get it."""


class UnreachableError(ServerError):
    """Nobody listens."""


def api_key() -> str | None:
    """The key that servers may ask for. Command lines can be read by others."""
    return os.environ.get("ENGRAM_SERVER_KEY") or None


@dataclasses.dataclass(frozen=True)
class Question:
    """What a server is asked: images and state by name, with a time axis if there is a history.

    episode: env_id, seed, step and proprio of the episode, for servers that may know it.
    """

    images: Mapping[str, Array]
    state: Mapping[str, Array]
    prompt: str
    has_time: bool
    env_id: str
    episode: Mapping[str, Any] | None

    @property
    def extras(self) -> dict[str, Any]:
        return {} if self.episode is None else {"engram": dict(self.episode)}


class Connection(abc.ABC):
    """A connection to a server, used by one episode after another."""

    def __init__(self, options: ServerOptions, keys: Keys, session: str) -> None:
        self.options = options
        self.keys = keys
        self.session = session
        self.size: tuple[int, int] | None = None  # of images, if the server asks for one
        self.metadata: Any = None  # what the server has told of itself when it was connected to

    async def open(self) -> None:
        """Connects. A server that does not listen yet is waited for."""
        loop = asyncio.get_running_loop()
        end = loop.time() + self.options.wait
        while True:
            try:
                await self._connect()
                return
            except OSError as error:
                if loop.time() >= end:
                    reason = os.strerror(error.errno) if error.errno else type(error).__name__
                    raise UnreachableError(
                        f"policy server {self.options.url} cannot be reached within "
                        f"{self.options.wait:g} s: {reason}"
                    ) from None
            await asyncio.sleep(_RETRY_SECONDS)

    @abc.abstractmethod
    async def _connect(self) -> None:
        """Raises OSError if nobody listens."""

    @abc.abstractmethod
    async def begin(self, env_id: str) -> None:
        """A new episode begins; the connection may be used already."""

    async def finish(self) -> None:
        """Ends the connection with the episode."""
        await self.close()

    @abc.abstractmethod
    async def ask(self, question: Question) -> Any:
        """The actions of an answer, unchecked."""

    @abc.abstractmethod
    async def close(self) -> None:
        """Also after failures."""

    async def require_silence(self, reading: Callable[[], Coroutine[Any, Any, Any]]) -> None:
        """Refuses what was sent before it was asked for: it would answer the next question.

        Args:
            reading: Waits for what the server sends.
        """
        await asyncio.sleep(0)  # what has come is received
        task = asyncio.ensure_future(reading())
        await asyncio.sleep(0)
        if not task.done():
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)
        elif task.exception() is None:
            if isinstance(task.result(), str):
                raise self.reported(task.result())
            raise self.fail("answered twice; one answer to a question needed")

    async def decoded(self, read: Callable[[bytes], Any], data: bytes) -> Any:
        """An answer's value."""
        try:
            return await limits.decoded(read, data)
        except CodecError as error:
            raise self.fail(f"answered with {error}") from None

    def fail(self, what: str) -> ServerError:
        return ServerError(f"policy server {self.options.url} {what}")

    def too_large(self) -> ServerError:
        return self.fail(f"answered with more than {limits.ANSWER >> 20} MiB")

    def lost(self, how: str) -> LostError:
        return LostError(f"policy server {self.options.url} {how}")

    def reported(self, message: Any) -> ServerError:
        """A failure in the server's words; of a traceback the last line."""
        text = str(message)[-limits.WORDS :]
        lines = [line for line in text.splitlines() if line.strip()]
        return self.fail(f"reports: {lines[-1].strip() if lines else 'a failure without words'}")

    def joined(self, answer: Any, names: tuple[str, ...]) -> Any:
        """The parts of an action, put together."""
        if not isinstance(answer, dict):
            raise self.fail(f"answered with {_kind(answer)}, a map with {', '.join(names)} needed")
        missing = [name for name in names if name not in answer]
        if missing:
            given = ", ".join(f"{name!s:.100}" for name in list(answer)[:20]) or "nothing"
            raise self.fail(f"answered with {given}; {missing[0]} needed")
        if len(names) == 1:
            return answer[names[0]]
        parts = [self.numbers(answer[name]) for name in names]
        parts = [p[..., None] if p.ndim < max(q.ndim for q in parts) else p for p in parts]
        try:
            return np.concatenate(parts, -1)
        except ValueError:
            shapes = ", ".join(f"{name} {p.shape}" for name, p in zip(names, parts))
            raise self.fail(f"answered with parts that do not fit together: {shapes}") from None

    def numbers(self, value: Any) -> Array:
        """An array of real numbers."""
        try:
            array = np.asarray(value)
        except ValueError:
            array = np.asarray(None)
        if array.dtype.kind not in "iuf":
            raise self.fail(f"answered with {_kind(value)}, an array of numbers needed")
        return array

    def chunk(self, value: Any, dim: int) -> Array:
        """Actions (K, dim) of an answer, all finite."""
        if isinstance(value, (list, tuple)) and value and len(value) <= limits.ACTIONS:
            value = [self.numbers(part) for part in value]
        array = self.numbers(value)
        if array.ndim == 3 and array.shape[0] == 1:
            array = array[0]
        if array.ndim == 1:
            array = array[None]
        if array.ndim != 2 or array.shape[1] != dim or not 1 <= len(array) <= limits.ACTIONS:
            shape = np.shape(value)
            raise self.fail(f"answered with actions of shape {shape}, (K, {dim}) or ({dim}) needed")
        with np.errstate(over="ignore"):
            array = array.astype(np.float32)
        bad = np.argwhere(~np.isfinite(array))
        if len(bad):
            row, column = bad[0]
            raise self.fail(
                f"answered with {array[row, column]} in component {column} of action {row}, "
                "a finite number needed"
            )
        return array


def _kind(value: Any) -> str:
    if isinstance(value, str):
        return f"the text {value[:60]!r}"
    if isinstance(value, np.ndarray):
        return f"an array of {value.dtype}"
    return f"a {type(value).__name__}"
