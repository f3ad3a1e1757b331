"""Arrays of the user's that a batch writes its outputs to: NumPy's, or tensors of torch."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from engram import _core
from engram._args.methods import kind_of
from engram._args.values import text_keys
from engram.envs.spaces import Layout
from engram.errors import InvalidArgumentError


class OutputArrays:
    """The keyword ``out`` of a batch: dicts from outputs to arrays, which take turns."""

    def __init__(self, batch: _core.Batch, out: Any) -> None:
        self._batch = batch
        self._turns = _turns_of(batch, out)
        self._arrays = [  # kept for as long as the batch may write to them
            [(name, _writable(batch, name, value)) for name, value in turn.items()]
            for turn in self._turns
        ]
        if any(turn.keys() != self._turns[0].keys() for turn in self._turns):
            raise InvalidArgumentError("out: all dicts must be for the same outputs")
        _require_apart([one for turn in self._arrays for one in turn])
        batch.write_outputs(self._arrays)

    def __contains__(self, name: object) -> bool:
        return name in self._turns[0]

    def getter(self, name: str) -> Callable[[], Any]:
        """A function that returns the user's array with the newest values."""
        if len(self._turns) == 1:
            array = self._turns[0][name]
            return lambda: array
        arrays = [turn[name] for turn in self._turns]
        return lambda: arrays[self._batch.output_buffer]

    def observation(
        self, layout: Layout, whole: Any, exported: Callable[[Any], Callable[[], Any]]
    ) -> Callable[[], Any]:
        """A function that returns the observation, with the user's arrays where there are any.

        Args:
            layout: Of the observation.
            whole: Views of it.
            exported: Makes a function that returns a view, or a copy of it.
        """
        own = [key for key in layout.keys if key in self]
        if own and layout.parts:
            parts = {
                key: self.getter(name) if name in own else exported(whole[key])
                for key, name in layout.parts.items()
            }
            return lambda: {key: part() for key, part in parts.items()}
        return exported(whole) if isinstance(whole, dict) or not own else self.getter(own[0])


def _turns_of(batch: _core.Batch, out: Any) -> list[dict[str, Any]]:
    """One dict for each turn: those that are given, or the rows of arrays with a leading axis."""
    given = [out] if isinstance(out, Mapping) else out
    if not isinstance(given, Sequence) or isinstance(given, str) or not given:
        raise InvalidArgumentError(
            f"out: {kind_of(out)} given; a dict from names to arrays, or a list of them, needed"
        )
    turns = [dict(text_keys("out", turn)) for turn in given]
    lengths = {
        len(value)
        for name, value in turns[0].items()
        if getattr(value, "ndim", 0) == np.asarray(batch.output(name)).ndim + 1
    }
    if len(turns) > 1 or not lengths:
        return turns
    (turn,) = turns
    if len(lengths) > 1 or 0 in lengths:
        raise InvalidArgumentError(
            f"out: leading axes of {', '.join(map(str, sorted(lengths)))} given, one needed"
        )
    (length,) = lengths
    return [
        {name: _row(name, value, t, length) for name, value in turn.items()} for t in range(length)
    ]


def _row(name: str, value: Any, turn: int, length: int) -> Any:
    if not hasattr(value, "ndim") or value.ndim == 0 or len(value) != length:
        raise InvalidArgumentError(f"out[{name!r}]: a leading axis of {length} needed, as others")
    return value[turn]


def _require_apart(arrays: list[tuple[str, np.ndarray]]) -> None:
    """Raises InvalidArgumentError if two arrays, which have no gaps, have memory in common."""
    places = sorted((array.ctypes.data, array.nbytes, name) for name, array in arrays)
    for (start, size, name), (following, _, other) in pairwise(places):
        if start + size > following:
            raise InvalidArgumentError(
                f"out: the arrays of {name!r} and {other!r} share memory; separate ones needed"
            )


def _writable(batch: _core.Batch, name: str, value: Any) -> np.ndarray:
    """The memory of an array or tensor, which must be like the output."""
    like: Any = batch.output(name)
    array = value
    if not isinstance(value, np.ndarray) and hasattr(value, "data_ptr"):
        try:
            array = value.numpy()
        except (TypeError, RuntimeError) as error:
            raise InvalidArgumentError(
                f"out[{name!r}]: a tensor in the memory of the processor needed ({error})"
            ) from None
    if (
        isinstance(array, np.ndarray)
        and array.dtype == like.dtype
        and array.shape == like.shape
        and array.flags.carray
    ):
        return array
    raise InvalidArgumentError(
        f"out[{name!r}]: {kind_of(array)} given; a writable {like.dtype} array of shape "
        f"{like.shape} without gaps is needed"
    )
