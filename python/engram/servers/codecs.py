"""Arrays in msgpack and JSON, as the protocols write them. What is read was written by others."""

from __future__ import annotations

import ast
import base64
import io
import json
import math
from typing import Any

import msgpack
import numpy as np
import numpy.typing as npt

LARGEST = 64 << 20  # bytes of an answer
_KINDS = "biuf"  # of arrays


class CodecError(Exception):
    """What was received is not what the protocol allows."""


def _array(data: Any, dtype: Any, shape: Any) -> npt.NDArray[Any]:
    """An array from its parts, of which none is trusted."""
    if not isinstance(data, bytes) or not isinstance(dtype, str):
        raise CodecError("an array without bytes or type")
    try:
        kind = np.dtype(dtype)
    except (TypeError, ValueError, SyntaxError):
        raise CodecError(f"an array of type {dtype!r:.40}") from None
    sides = list(shape) if isinstance(shape, (list, tuple)) else [-1]
    if kind.kind not in _KINDS or not all(type(s) is int and s >= 0 for s in sides):
        raise CodecError(f"an array of type {dtype!r:.40} and shape {shape!r:.60}")
    if math.prod(sides) * kind.itemsize != len(data):
        raise CodecError(f"an array of shape {sides}, type {dtype} and {len(data)} bytes")
    return np.frombuffer(data, kind).reshape(sides)


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
    if value.get("__image__"):
        return _image(value)
    return value


def _image(value: dict[Any, Any]) -> npt.NDArray[Any]:
    """An image of vla-eval's."""
    data = value.get("data")
    if value.get("format") == "raw":
        return _array(data, value.get("dtype"), value.get("shape"))
    from PIL import Image

    if not isinstance(data, bytes):
        raise CodecError("an image without bytes")
    try:
        return np.array(Image.open(io.BytesIO(data), formats=("PNG", "JPEG")))
    except (OSError, ValueError, Image.DecompressionBombError) as error:
        raise CodecError(f"an image that cannot be read: {error}") from None


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


def _read_npy(data: Any) -> npt.NDArray[Any]:
    """An array of np.save; its header is not believed before the bytes are counted."""
    if not isinstance(data, bytes) or data[:6] != b"\x93NUMPY" or len(data) < 12:
        raise CodecError("an array that np.save did not write")
    wide = data[6] >= 2
    start = 12 if wide else 10
    end = start + int.from_bytes(data[8 : 12 if wide else 10], "little")
    try:
        if end - start > 10_000:
            raise ValueError
        header = ast.literal_eval(data[start:end].decode("latin1").strip())
        dtype, order, shape = header["descr"], header["fortran_order"], header["shape"]
    except (ValueError, SyntaxError, KeyError, TypeError, MemoryError, RecursionError):
        raise CodecError("an array whose header cannot be read") from None
    if order is True and isinstance(shape, tuple):
        return _array(data[end:], dtype, shape[::-1]).T
    return _array(data[end:], dtype, shape)


def _unpack_gr00t(value: dict[Any, Any]) -> Any:
    return _read_npy(value.get("as_npy")) if "__ndarray_class__" in value else value


def pack_gr00t(value: Any) -> bytes:
    return bytes(msgpack.packb(value, default=_pack_gr00t))


def unpack_gr00t(data: bytes) -> Any:
    return _unpacked(data, _unpack_gr00t)


def unpack(data: bytes) -> Any:
    """A message of openpi or vla-eval."""
    return _unpacked(data, _unpack)


def _unpacked(data: bytes, hook: Any) -> Any:
    try:
        return msgpack.unpackb(data, object_hook=hook)
    except CodecError:
        raise
    except (ValueError, TypeError, msgpack.exceptions.UnpackException, RecursionError):
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


def unpack_json(data: bytes | str) -> Any:
    try:
        return json.loads(data, object_hook=_decode_json)
    except (ValueError, RecursionError):
        raise CodecError(f"{len(data)} bytes that are no JSON: {data[:40]!r}") from None
