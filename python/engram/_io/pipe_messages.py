"""Messages of the pipe protocol, for both of its sides; docs/evaluation.md has the protocol."""

from __future__ import annotations

import math
import struct
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

HELLO, TASK, REQUEST, CHUNKS, FAILED = 1, 2, 3, 4, 5
FRAMES, IDENTITY = 8, 9
SIGNATURE = struct.pack("<2I", 0x4D474E45, 1)  # magic number and version, in both greetings
OBSERVES = {"rgb": 1, "state": 2, "objects": 3}


def packed(kind: int, body: bytes) -> bytes:
    return struct.pack("<2I", kind, len(body)) + body


def packed_text(text: str) -> bytes:
    data = text.encode()
    return struct.pack("<I", len(data)) + data


def packed_request(observation: Mapping[str, Any]) -> bytes:
    """The body of a request for rows of an observation of engram.evaluate; some parts may lack."""
    parts = [struct.pack("<I", len(observation["slot"]))]
    parts += [observation[name].astype("<i4").tobytes() for name in ("slot", "episode", "step")]
    parts.append(observation["first"].astype("u1").tobytes())
    parts += [packed_text(one) for one in observation["instruction"]]
    for name, kind in (("proprio", "<f4"), ("rgb", "u1"), ("state", "<f4"), ("seed", "<u8")):
        if observation.get(name) is not None:
            parts.append(observation[name].astype(kind).tobytes())
    return b"".join(parts)


class Reader:
    """Takes values from the body of a message; EOFError if it ends too early."""

    def __init__(self, body: bytes) -> None:
        self._rest = memoryview(body)

    def take(self, size: int) -> memoryview:
        if size > len(self._rest):
            raise EOFError(f"{len(self._rest)} bytes given, {size} needed")
        taken, self._rest = self._rest[:size], self._rest[size:]
        return taken

    def array(self, kind: str, *shape: int) -> npt.NDArray[Any]:
        dtype = np.dtype(kind)
        return np.frombuffer(self.take(math.prod(shape) * dtype.itemsize), dtype).reshape(shape)

    def number(self) -> int:
        return int(self.array("<u4", 1)[0])

    def text(self) -> str:
        return bytes(self.take(self.number())).decode()

    @property
    def rest(self) -> memoryview:
        """The bytes that have not been taken."""
        return self._rest

    @property
    def at_end(self) -> bool:
        return not self._rest
