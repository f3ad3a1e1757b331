"""The pipe protocol of docs/evaluation.md for a policy in Python: a server behind pipes."""

from __future__ import annotations

import os
import struct
import sys
from collections.abc import Callable, Mapping
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from engram._io import pipe_messages as pipes
from engram.errors import Error
from engram.servers.identity import packed_identity

Policy = Callable[[dict[str, Any]], "list[npt.NDArray[np.float32]]"]


class Bridge:
    """Answers the requests of a simulator until its input ends.

    Args:
        make_policy: Makes the policy for actions of that many numbers.
        identity: What the policy is, as JSON has it; by default what it has under that name.
    """

    def __init__(
        self, make_policy: Callable[[int], Policy], identity: Mapping[str, Any] | None = None
    ) -> None:
        self._make_policy = make_policy
        self._identity = identity
        self._identified = False
        self._policy: Policy | None = None
        self._hello = dict.fromkeys(_HELLO_FIELDS, 0)
        self._task = ""
        self._row = 0  # numbers of a row of objects or state

    def run(self, source: BinaryIO, sink: BinaryIO) -> int:
        """Returns the exit code."""

        def send(kind: int, body: bytes) -> None:
            sink.write(pipes.packed(kind, body))
            sink.flush()

        while len(head := source.read(8)) == 8:
            kind, size = struct.unpack("<II", head)
            message = pipes.Reader(source.read(size))
            try:
                answer = self._answer(kind, message)
            except Error as error:
                send(pipes.FAILED, str(error).encode())
                return 1
            if answer is not None:
                identity = self._identity or getattr(self._policy, "identity", None)
                if identity and not self._identified:
                    send(pipes.IDENTITY, packed_identity(identity))
                    self._identified = True
                send(*answer)
        return 0

    def close(self) -> None:
        """Ends the policy, if it has an end."""
        close = getattr(self._policy, "close", None)
        if close is not None:
            close()

    def _answer(self, kind: int, message: pipes.Reader) -> tuple[int, bytes] | None:
        if kind == pipes.HELLO:
            self._hello = {name: message.number() for name in _HELLO_FIELDS}
            self._policy = self._make_policy(self._hello["action"])
            return pipes.HELLO, pipes.SIGNATURE
        if kind == pipes.TASK:
            self._task, self._row = message.text(), message.number()
            return None
        assert kind == pipes.REQUEST
        assert self._policy is not None
        chunks = self._policy(self._observation(message))
        parts = [struct.pack("<I", len(chunks))]
        for chunk in chunks:
            parts += [struct.pack("<3I", 2, *chunk.shape), chunk.astype("<f4").tobytes()]
        return pipes.CHUNKS, b"".join(parts)

    def _observation(self, message: pipes.Reader) -> dict[str, Any]:
        """A request as an observation of engram.evaluate."""
        count, hello = message.number(), self._hello
        seen: dict[str, Any] = {"env_id": self._task, "worker": 0, "rgb": None, "state": None}
        for name in ("slot", "episode", "step"):
            seen[name] = message.array("<i4", count)
        seen["first"] = message.array("u1", count)
        seen["instruction"] = [message.text() for _ in range(count)]
        seen["proprio"] = message.array("<f4", count, hello["proprio"])
        if hello["observes"] == pipes.OBSERVES["rgb"]:
            shape = (hello["height"], hello["width"], hello["channels"])
            seen["rgb"] = message.array("u1", count, *shape)
        if self._row:
            seen["state"] = message.array("<f4", count, self._row)
        if not message.at_end:
            seen["seed"] = message.array("<u8", count)
        return seen


_HELLO_FIELDS = (
    "magic", "version", "observes", "height", "width", "channels", "proprio", "action", "max_slots",
)  # fmt: skip


def serve_pipes(
    make_policy: Callable[[int], Policy], identity: Mapping[str, Any] | None = None
) -> int:
    """Answers over standard input and output; whatever prints writes to standard error."""
    sink = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    return run_bridge(Bridge(make_policy, identity), sink)


def run_bridge(bridge: Bridge, sink: BinaryIO) -> int:
    """Answers over standard input and the sink until the input ends."""
    try:
        return bridge.run(sys.stdin.buffer, sink)
    finally:
        bridge.close()
