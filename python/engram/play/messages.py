"""Validation of the page's messages. Anything that is not listed here is refused."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import Any

LARGEST = 1 << 14  # bytes of a message
MAX_SEED = 2**63 - 1  # of demonstrations
_LONGEST_ID = 100
_LONGEST_NAME = 60
_MOST_NAMES = 64
_MOST_VALUES = 64
_MOST_CHOICES = 1000
_MOST_NUMBER = 2**53 - 1  # JavaScript's whole numbers


class MessageError(Exception):
    """A message that the page would not send; the text names the fault."""


def parse(text: str) -> dict[str, Any]:
    """The message, if it has exactly the fields of its kind, each of its type."""
    try:
        message = json.loads(text, parse_constant=_no_constant)
    except (ValueError, RecursionError):
        raise MessageError("no JSON") from None
    if not isinstance(message, dict):
        raise MessageError("a message is an object")
    kind = message.get("do")
    if not isinstance(kind, str) or kind not in _KINDS:
        raise MessageError(f"do: {short(kind)} given; allowed: {', '.join(_KINDS)}")
    fields = _KINDS[kind]
    for name in message:
        if name != "do" and name not in fields:
            raise MessageError(f"{kind} has no field {short(name)}")
    for name, (needed, check) in fields.items():
        if name in message:
            check(f"{kind}.{name}", message[name])
        elif needed:
            raise MessageError(f"{kind} lacks {name}")
    return message


def short(value: Any) -> str:
    """A value for messages."""
    text = ascii(value)
    return text if len(text) <= 60 else text[:60] + "..."


def _no_constant(name: str) -> float:
    raise ValueError(name)


def _wrong(name: str, value: Any, needed: str) -> MessageError:
    return MessageError(f"{name}: {short(value)} given; {needed} needed")


def _number(low: float, high: float) -> Callable[[str, Any], None]:
    def check(name: str, value: Any) -> None:
        good = type(value) in (int, float) and low <= value <= high and math.isfinite(value)
        if not good:
            raise _wrong(name, value, f"a number from {low} to {high}")

    return check


def _whole(low: int, high: int) -> Callable[[str, Any], None]:
    def check(name: str, value: Any) -> None:
        if type(value) is not int or not low <= value <= high:
            raise _wrong(name, value, f"a whole number from {low} to {high}")

    return check


def _flag(name: str, value: Any) -> None:
    if type(value) is not bool:
        raise _wrong(name, value, "true or false")


def _text(most: int) -> Callable[[str, Any], None]:
    def check(name: str, value: Any) -> None:
        if not isinstance(value, str) or not 1 <= len(value) <= most or not value.isascii():
            raise _wrong(name, value, f"a text of 1 to {most} ASCII characters")

    return check


def _seed(name: str, value: Any) -> None:
    # A text: JavaScript's numbers cannot represent all of them.
    if value is None:
        return
    if not (isinstance(value, str) and value.isascii() and value.isdigit() and len(value) <= 19):
        raise _wrong(name, value, f"null or a text of digits, 0 to {MAX_SEED}")
    if int(value) > MAX_SEED:
        raise _wrong(name, value, f"null or a text of digits, 0 to {MAX_SEED}")


def _action(name: str, value: Any) -> None:
    if not isinstance(value, list) or len(value) != 7:
        raise _wrong(name, value, "a list of 7 numbers")
    for one in value:
        _number(-1, 1)(name, one)


def _scalar(name: str, value: Any) -> None:
    if isinstance(value, str):
        _text(_LONGEST_NAME)(name, value)
    else:
        _number(-1e15, 1e15)(name, value)


def _values(name: str, value: Any) -> None:
    """Names with a number, a text, or a list of them; the simulator checks their meaning."""
    if not isinstance(value, dict) or len(value) > _MOST_NAMES:
        raise _wrong(name, value, f"an object of at most {_MOST_NAMES} names")
    for key, one in value.items():
        _text(_LONGEST_NAME)(f"name in {name}", key)
        if isinstance(one, list):
            if len(one) > _MOST_VALUES:
                raise _wrong(name, one, f"a list of at most {_MOST_VALUES} values")
            for part in one:
                _scalar(name, part)
        else:
            _scalar(name, one)


def _choices(name: str, value: Any) -> None:
    """Indices of a question's choices; the simulator checks how many it allows."""
    if not isinstance(value, list) or not 1 <= len(value) <= _MOST_VALUES:
        raise _wrong(name, value, f"a list of 1 to {_MOST_VALUES} whole numbers")
    for one in value:
        _whole(0, _MOST_CHOICES)(name, one)


_Check = Callable[[str, Any], None]
_EPISODE_SPEC: dict[str, tuple[bool, _Check]] = {
    "id": (True, _text(_LONGEST_ID)),
    "seed": (False, _seed),
    "pins": (False, _values),
    "constants": (False, _values),
    "options": (False, _values),
}
_SOURCE = _text(20)
# Fields by kind of message: required or not, and the check of the value.
_KINDS: dict[str, dict[str, tuple[bool, _Check]]] = {
    "play": {**_EPISODE_SPEC, "choices": (False, _flag)},  # a new episode
    "choose": {"choices": (True, _choices)},  # answers the question
    "act": {
        "a": (True, _action),
        "n": (True, _whole(0, _MOST_NUMBER)),
        "held": (True, _flag),  # a key, a stick or the mouse is in use
    },
    "run": {"on": (True, _flag)},  # or pause
    "speed": {"of": (True, _number(0.02, 1)), "turns": (True, _flag)},
    "step": {"a": (True, _action), "n": (True, _whole(0, _MOST_NUMBER))},
    "seen": {"n": (True, _whole(0, _MOST_NUMBER))},
    "save": {},
    "review": {},  # plays back the last episode
    "watch": {**_EPISODE_SPEC, "source": (True, _SOURCE)},
    "stored": {
        "folder": (True, _whole(0, 1000)),
        "task": (True, _whole(0, 100_000)),
        "episode": (True, _whole(0, 10_000_000)),
    },
    "frame": {"n": (True, _whole(0, 10_000_000))},
    "grid": {**_EPISODE_SPEC, "source": (True, _SOURCE)},
    "leave": {},
    "stop": {},  # gives up the episode that is played in the background
    "take": {},  # takes over from another tab
}
