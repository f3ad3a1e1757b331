"""Refusal of unknown keywords, in the name of the function that was called."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from engram._args.values import nearest
from engram.errors import InvalidArgumentError
from engram.typing import BatchOptions, EnvOptions

_SINGLE = ("obs_mode", *EnvOptions.__annotations__)
_BATCH = ("num_envs", "obs_mode", *BatchOptions.__annotations__)


def check_batch(caller: str, given: Mapping[str, Any]) -> None:
    """Allows those of a batch."""
    _check(caller, given, _BATCH)


def check_single(caller: str, given: Mapping[str, Any], own: Iterable[str] = ()) -> None:
    """Allows those of a single environment, and the caller's own."""
    for name in given:
        if name in _BATCH and name not in (*_SINGLE, *own):
            raise InvalidArgumentError(
                f"{name}: {given[name]!r} given to {caller}; engram.make_vec takes it"
            )
    _check(caller, given, (*own, *_SINGLE))


def _check(caller: str, given: Iterable[str], allowed: Iterable[str]) -> None:
    allowed = list(allowed)
    for name in given:
        if name not in allowed:
            meant = nearest(name, allowed)
            hint = "" if meant is None else f". Did you mean '{meant}'?"
            raise TypeError(f"{caller}() got an unexpected keyword argument '{name}'{hint}")
