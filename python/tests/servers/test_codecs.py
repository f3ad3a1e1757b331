"""What the codecs of policy servers accept, and one byte or one entry more."""

from __future__ import annotations

import json
import struct
from typing import Any

import fuzz_codecs
import msgpack
import numpy as np
import pytest

from engram.servers import codecs, limits


def array_of(dtype: Any, shape: Any, data: bytes) -> bytes:
    parts = {"__ndarray__": True, "data": data, "dtype": dtype, "shape": shape}
    return bytes(msgpack.packb(parts))


def nested(depth: int) -> Any:
    value: Any = 1
    for _ in range(depth):
        value = [value]
    return value


def text_message(count: int) -> bytes:
    return b"\xdb" + struct.pack(">I", count) + b"x" * count


PACKED = {
    "values": (limits.VALUES, lambda n: msgpack.packb([0] * n), "more than 100,000 values"),
    "values of maps": (
        limits.VALUES // 2,
        lambda n: msgpack.packb({str(i): 0 for i in range(n)}),
        "more than 100,000 values",
    ),
    "depth": (limits.DEPTH, lambda n: msgpack.packb(nested(n)), "more than 32 deep"),
    "text": (limits.TEXT, text_message, "no msgpack"),
    "axes": (limits.AXES, lambda n: array_of("<f4", [1] * n, bytes(4)), "an array of type"),
    "bytes of an array": (28, lambda n: array_of("<f4", [7], bytes(n)), "7"),
}


@pytest.mark.parametrize("case", PACKED)
@pytest.mark.parametrize("read", [codecs.unpack, codecs.unpack_gr00t])
def test_msgpack_and_one_more(case, read):
    most, make, words = PACKED[case]
    read(bytes(make(most)))
    if case in ("axes", "bytes of an array") and read is codecs.unpack_gr00t:
        return  # other arrays
    with pytest.raises(codecs.CodecError, match=words):
        read(bytes(make(most + 1)))


WRITTEN = {
    "values": (limits.VALUES, lambda n: json.dumps([0] * n), "more than 100,000 values"),
    "depth": (limits.DEPTH, lambda n: json.dumps(nested(n)), "more than 32 deep"),
    "text": (limits.TEXT, lambda n: '"é' + "x" * (n - 4) + '"', "not all of them ASCII"),
    "escapes": (limits.TEXT, lambda n: '"\\u0100' + "x" * (n - 8) + '"', "not all of them ASCII"),
}


@pytest.mark.parametrize("case", WRITTEN)
def test_json_and_one_more(case):
    most, make, words = WRITTEN[case]
    codecs.unpack_json(make(most).encode())
    with pytest.raises(codecs.CodecError, match=words):
        codecs.unpack_json(make(most + 1).encode())


@pytest.mark.parametrize("dtype", ["<f4", ">i8", "|u1", "|b1", "float32", "uint8", "bool", "<f2"])
def test_types_of_arrays(dtype):
    kind = np.dtype(dtype)
    array = codecs.unpack(array_of(dtype, [2], bytes(2 * kind.itemsize)))
    assert array.dtype == kind
    assert array.shape == (2,)


@pytest.mark.parametrize("dtype", ["O", "V8", "<U4", "S4", "<M8[s]", "<c8", "f8,f8", "(2,)f8", ""])
def test_other_types(dtype):
    with pytest.raises(codecs.CodecError, match="an array of type"):
        codecs.unpack(array_of(dtype, [0], b""))


def test_a_slice_of_the_fuzzed_messages():
    """``fuzz_codecs.py`` plays any number."""
    counts, findings = fuzz_codecs.play(0, 400)
    assert not findings
    assert counts["read"] > 20
    assert counts["refused"] > 400
