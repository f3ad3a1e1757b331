"""A command of the pipe protocol behind pipes, with chunks and histories of policy servers."""

from __future__ import annotations

import contextlib
import json
import struct
import subprocess
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt

from engram._io import pipe_messages as pipes
from engram.errors import UnavailableError
from engram.servers.bridge import Bridge
from engram.servers.chunked import ChunkedPolicy
from engram.servers.limits import IDENTITY
from engram.servers.options import replan_of

_LARGEST = 1 << 28  # bytes of an answer


class PipedBridge(Bridge):
    """Passes a simulator's messages on to a command, with frames, when actions are used up.

    Args:
        command: For /bin/sh.
        replan, history: As of ChunkedPolicy, as text; None: as usual.
    """

    def __init__(self, command: str, replan: str | None, history: str | None) -> None:
        super().__init__(lambda _: ChunkedPolicy(self._ask, replan_of(replan), history or "last"))
        self._process = subprocess.Popen(
            command, shell=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )

    def close(self) -> None:
        """Ends the command's input, and waits for its end."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()

    def _answer(self, kind: int, message: pipes.Reader) -> tuple[int, bytes] | None:
        if kind == pipes.HELLO:
            self._send(kind, message.rest)
            greeting = self._receive(pipes.HELLO)
            super()._answer(kind, message)
            return pipes.HELLO, greeting
        if kind == pipes.TASK:
            self._send(kind, message.rest)
        return super()._answer(kind, message)

    # --- the command ---

    def _ask(self, observation: dict[str, Any]) -> list[npt.NDArray[Any]]:
        if "frames" in observation:
            self._send(pipes.FRAMES, b"".join(_packed_frames(f) for f in observation["frames"]))
        self._send(pipes.REQUEST, pipes.packed_request(observation))
        reader = pipes.Reader(self._receive(pipes.CHUNKS))
        try:
            return [_chunk(reader) for _ in range(reader.number())]
        except EOFError:
            self._fail("its answer ends too early")

    def _send(self, kind: int, body: bytes | memoryview) -> None:
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(pipes.packed(kind, bytes(body)))
            self._process.stdin.flush()
        except OSError:
            self._fail(f"it has ended with exit code {self._process.wait()}")

    def _receive(self, expected: int) -> bytes:
        kind, size = struct.unpack("<2I", self._read(8))
        if kind == pipes.IDENTITY and size <= IDENTITY:
            self._identity = self._identity_in(self._read(size))
            kind, size = struct.unpack("<2I", self._read(8))
        if kind not in (expected, pipes.FAILED) or size > _LARGEST:
            self._fail(f"it answered with message {kind} of {size} bytes, {expected} needed")
        body = self._read(size)
        if kind == pipes.FAILED:
            self._fail(f"it reported: {body[:2000].decode(errors='replace')}")
        return body

    def _identity_in(self, body: bytes) -> dict[str, Any]:
        told: Any = None
        with contextlib.suppress(ValueError):
            told = json.loads(body)
        if not isinstance(told, dict):
            self._fail("it told of itself something else than a JSON object")
        return told

    def _read(self, size: int) -> bytes:
        assert self._process.stdout is not None
        body = self._process.stdout.read(size)
        if len(body) < size:
            self._fail(f"it has ended with exit code {self._process.wait()}")
        return body

    def _fail(self, what: str) -> NoReturn:
        raise UnavailableError(f"--policy-command: {what}")


def _packed_frames(frames: dict[str, npt.NDArray[Any] | None]) -> bytes:
    steps = frames["step"]
    assert steps is not None
    parts = [struct.pack("<I", len(steps))]
    for name, kind in (("step", "<i4"), ("proprio", "<f4"), ("rgb", "u1"), ("state", "<f4")):
        values = frames[name]
        if values is not None:
            parts.append(np.ascontiguousarray(values, kind).tobytes())
    return b"".join(parts)


def _chunk(reader: pipes.Reader) -> npt.NDArray[Any]:
    shape = [reader.number() for _ in range(min(reader.number(), 3))]
    return reader.array("<f4", *shape)
