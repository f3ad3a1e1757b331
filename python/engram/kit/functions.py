"""Functions over arrays that have the same bits on every machine.

NumPy chooses its instructions by the processor, so that the last bits of ``np.sin`` or of a sum
along an axis may differ between machines. These do not: tasks that use them keep the promise that
the same seed has the same bits everywhere. Sums, products, square roots and comparisons of NumPy
are exact and may be used as they are.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engram import _core
from engram.errors import InvalidArgumentError

Reals = NDArray[np.float64]


def sin(x: ArrayLike) -> Reals:
    """Sine of angles in radians."""
    return _apply("sin", x)


def cos(x: ArrayLike) -> Reals:
    """Cosine of angles in radians."""
    return _apply("cos", x)


def tan(x: ArrayLike) -> Reals:
    """Tangent of angles in radians."""
    return _apply("tan", x)


def asin(x: ArrayLike) -> Reals:
    """Arc sine, radians."""
    return _apply("asin", x)


def exp(x: ArrayLike) -> Reals:
    """Exponential function."""
    return _apply("exp", x)


def log(x: ArrayLike) -> Reals:
    """Natural logarithm."""
    return _apply("log", x)


def tanh(x: ArrayLike) -> Reals:
    """Hyperbolic tangent."""
    return _apply("tanh", x)


def atan2(y: ArrayLike, x: ArrayLike) -> Reals:
    """Angle of the points (x, y), radians."""
    return _apply("atan2", y, x)


def hypot(x: ArrayLike, y: ArrayLike) -> Reals:
    """Length of the vectors (x, y)."""
    return _apply("hypot", x, y)


def length(vectors: NDArray[Any]) -> Reals:
    """Length of vectors along the last axis: shape (..., k) becomes (...)."""
    # Components first: NumPy is fast along the last axis, and adds in the order written here.
    parts = vectors.T.copy()
    parts *= parts
    total = parts[0]
    for i in range(1, len(parts)):
        total += parts[i]
    return np.sqrt(total).T


def distance(first: NDArray[Any], second: NDArray[Any]) -> Reals:
    """Distance between points along the last axis; the other axes are broadcast."""
    return length(first - second)


def _apply(name: str, x: ArrayLike, y: ArrayLike | None = None) -> Reals:
    first = np.asarray(x, np.float64, order="C")
    second = None
    if y is not None:
        try:
            pair = np.broadcast_arrays(first, np.asarray(y, np.float64))
        except ValueError:
            raise InvalidArgumentError(
                f"{name}: shapes {np.shape(x)} and {np.shape(y)} given, which do not go together"
            ) from None
        first, second = (np.asarray(one, order="C") for one in pair)
    out = np.empty_like(first)
    _core.real_function(name, first, second, out)
    return out
