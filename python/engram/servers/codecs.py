"""Arrays in msgpack and JSON, as the protocols write them. What is read was written by others."""

from __future__ import annotations

import base64
import io
import json
import math
import re
from typing import Any

import msgpack
import numpy as np
import numpy.typing as npt

from engram.servers import limits
from engram.servers.limits import CodecError

_NUMBERS = ("b1", "i1", "u1", "i2", "u2", "f2", "i4", "u4", "f4", "i8", "u8", "f8")
_TYPES = {order + kind: np.dtype(order + kind) for order in "<>|" for kind in _NUMBERS} | {
    np.dtype(kind).name: np.dtype("<" + kind) for kind in _NUMBERS
}  # of arrays, by the names that packages write


def _array(data: Any, dtype: Any, shape: Any) -> npt.NDArray[Any]:
    """An array from its parts, of which none is trusted."""
    if not isinstance(data, bytes) or not isinstance(dtype, str):
        raise CodecError("an array without bytes or type")
    kind = _TYPES.get(dtype)
    if kind is None:
        raise CodecError(f"an array of type {_start(dtype)}")
    sides = list(shape) if isinstance(shape, (list, tuple)) else [-1]
    if len(sides) > limits.AXES or not all(type(s) is int and s >= 0 for s in sides):
        raise CodecError(f"an array of type {dtype} and shape {sides[:9]!r:.60}")
    if math.prod(sides) * kind.itemsize != len(data):
        raise CodecError(f"an array of shape {sides}, type {dtype} and {len(data)} bytes")
    return np.frombuffer(data, kind).reshape(sides)


def _start(text: str | bytes) -> str:
    return repr(text[:40])


# --- msgpack: openpi and vla-eval ---


def _pack_openpi(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        value = np.ascontiguousarray(value)
        parts = (True, value.tobytes(), value.dtype.str, value.shape)
        return dict(zip((b"__ndarray__", b"data", b"dtype", b"shape"), parts))
    if isinstance(value, np.generic):
        return {b"__npgeneric__": True, b"data": value.item(), b"dtype": value.dtype.str}
    raise TypeError(f"{type(value).__name__} cannot be sent")


def _pack_vla_eval(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        value = np.ascontiguousarray(value)
        shape = [*value.shape]
        parts = (True, value.tobytes(), value.dtype.str, shape)
        return dict(zip(("__ndarray__", "data", "dtype", "shape"), parts))
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{type(value).__name__} cannot be sent")


def _unpack(value: dict[Any, Any]) -> Any:
    """Both ways to write an array."""
    if b"__ndarray__" in value:
        return _array(value.get(b"data"), value.get(b"dtype"), value.get(b"shape"))
    if "__ndarray__" in value:
        return _array(value.get("data"), value.get("dtype"), value.get("shape"))
    if b"__npgeneric__" in value:
        return value.get(b"data")
    return value


def pack_openpi(value: Any) -> bytes:
    return bytes(msgpack.packb(value, default=_pack_openpi))


def pack_vla_eval(value: Any) -> bytes:
    return bytes(msgpack.packb(value, default=_pack_vla_eval, use_bin_type=True))


# --- msgpack: GR00T ---


def _pack_gr00t(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        file = io.BytesIO()
        np.save(file, value, allow_pickle=False)
        return {"__ndarray_class__": True, "as_npy": file.getvalue()}
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{type(value).__name__} cannot be sent")


_NPY = re.compile(  # magic, version, length of the header, header
    rb"\x93NUMPY(?:\x01\x00..|[\x02\x03]\x00....)"
    rb"\{'descr': '([^']{1,8})', 'fortran_order': (True|False), "
    rb"'shape': \(([0-9, ]{0,160})\), ?\} *\n",
    re.DOTALL,
)


def _read_npy(data: Any) -> npt.NDArray[Any]:
    """An array of np.save; its header is not believed before the bytes are counted."""
    if not isinstance(data, bytes) or data[:6] != b"\x93NUMPY":
        raise CodecError("an array that np.save did not write")
    head = _NPY.match(data)
    try:
        if head is None:
            raise ValueError
        shape = [int(side) for side in head[3].decode().split(",") if side.strip()]
        dtype = head[1].decode()
    except ValueError:
        raise CodecError("an array whose header cannot be read") from None
    if head[2] == b"True":
        return _array(data[head.end() :], dtype, shape[::-1]).T
    return _array(data[head.end() :], dtype, shape)


def _unpack_gr00t(value: dict[Any, Any]) -> Any:
    return _read_npy(value.get("as_npy")) if "__ndarray_class__" in value else value


def pack_gr00t(value: Any) -> bytes:
    return bytes(msgpack.packb(value, default=_pack_gr00t))


def unpack_gr00t(data: bytes) -> Any:
    return _unpacked(data, _unpack_gr00t)


def unpack(data: bytes) -> Any:
    """A message of openpi or vla-eval."""
    return _unpacked(data, _unpack)


# Bytes behind the head of a value whose size is fixed.
_FIXED = {0xC0: 0, 0xC2: 0, 0xC3: 0, 0xCA: 4, 0xCB: 8} | {
    head: 1 << (head & 3) for head in range(0xCC, 0xD4)
}
# Bytes of the length behind the head of a text, and of the count behind that of a list or a map.
_TEXTS = {0xC4: 1, 0xC5: 2, 0xC6: 4, 0xD9: 1, 0xDA: 2, 0xDB: 4}
_COUNTS = {0xDC: 2, 0xDD: 4, 0xDE: 2, 0xDF: 4}


def _check_msgpack(data: bytes) -> None:
    """Refuses what has too many values or is too deep, before any of them is made."""
    left, values, at = [1], 0, 0  # left: values to come, of each map or list around
    while left:
        if left[-1] == 0:
            left.pop()
            continue
        left[-1] -= 1
        head = data[at]
        at += 1
        inside = 0
        if head in _FIXED:
            at += _FIXED[head]
        elif head in _TEXTS or head in _COUNTS:
            width = _TEXTS.get(head) or _COUNTS[head]
            count = int.from_bytes(data[at : at + width], "big")
            at += width
            if head in _TEXTS:
                at += count
            else:
                inside = count if head < 0xDE else 2 * count
        elif 0x80 <= head <= 0x9F:
            inside = (head & 15) * (2 if head < 0x90 else 1)
        elif 0xA0 <= head <= 0xBF:
            at += head & 31
        elif 0xC0 < head < 0xE0:  # extensions
            raise ValueError
        values += inside
        if inside:
            left.append(inside)
            _check_size(values, len(left) - 1)


def _check_size(values: int, depth: int) -> None:
    if values > limits.VALUES:
        raise CodecError(f"a message of more than {limits.VALUES:,} values")
    if depth > limits.DEPTH:
        raise CodecError(f"maps and lists more than {limits.DEPTH} deep")


def _unpacked(data: bytes, hook: Any) -> Any:
    try:
        _check_msgpack(data)
        return msgpack.unpackb(data, object_hook=hook, max_str_len=limits.TEXT)
    except CodecError:
        raise
    except (ValueError, TypeError, IndexError, msgpack.exceptions.UnpackException):
        raise CodecError(f"{len(data)} bytes that are no msgpack: {data[:20]!r}") from None


# --- JSON ---


def _encode_json(value: Any) -> Any:
    if isinstance(value, (np.ndarray, np.generic)):
        data = base64.b64encode(np.ascontiguousarray(value).tobytes()).decode()
        return {"__numpy__": data, "dtype": value.dtype.str, "shape": list(value.shape)}
    raise TypeError(f"{type(value).__name__} cannot be sent")


def _decode_json(value: dict[str, Any]) -> Any:
    if "__numpy__" not in value:
        return value
    try:
        data = base64.b64decode(value["__numpy__"], validate=True)
    except (ValueError, TypeError):
        raise CodecError("an array that is not base64") from None
    return _array(data, value.get("dtype"), value.get("shape"))


def pack_json(value: Any) -> bytes:
    return json.dumps(value, default=_encode_json).encode()


def unpack_json(data: bytes) -> Any:
    try:
        if len(data) > limits.TEXT and not (data.isascii() and b"\\u" not in data):
            raise CodecError(f"JSON of {len(data)} bytes, not all of them ASCII")
        _check_size(sum(map(data.count, (b",", b"[", b"{"))), 0)
        value = json.loads(data.decode(), object_hook=_decode_json)
        _check_size(0, _depth(value))
    except (ValueError, RecursionError):
        raise CodecError(f"{len(data)} bytes that are no JSON: {_start(data)}") from None
    return value


def _depth(value: Any) -> int:
    """How deep maps and lists are, counted to one more than is allowed."""
    depth, level = 0, [value]
    while depth <= limits.DEPTH and (level := [v for v in level if isinstance(v, (dict, list))]):
        parts = (v.values() if isinstance(v, dict) else v for v in level)
        depth, level = depth + 1, [one for part in parts for one in part]
    return depth
