"""Address and options of a policy server, from a URL, a command line or keywords."""

from __future__ import annotations

import argparse
import dataclasses
import shlex
import sys
import urllib.parse
from collections.abc import Mapping
from typing import Any

from engram.errors import InvalidArgumentError
from engram.servers import limits

PORTS = {"openpi": 8000, "gr00t": 5555, "act": 8000, "vla-eval": 8000}
RESETS = ("reconnect", "message", "none")
# How servers learn of a new episode, unless the user says otherwise.
_USUAL_RESET = {"openpi": "reconnect", "gr00t": "message", "act": "message", "vla-eval": "message"}


@dataclasses.dataclass(frozen=True)
class History:
    """Frames that a question has: the last one, all since the last question, or some at a stride.

    frames: 1 is the last frame alone, without a time axis; 0 all since the last question.
    """

    frames: int
    stride: int = 1

    @property
    def is_last(self) -> bool:
        return self.frames == 1

    @classmethod
    def parse(cls, text: str) -> History:
        if text in ("last", "since-last"):
            return cls(1 if text == "last" else 0)
        parts = text.split(",")
        good = len(parts) == 2 and all(p.isascii() and p.isdigit() and len(p) < 5 for p in parts)
        if not good or int(parts[0]) < 2 or int(parts[1]) < 1:
            raise InvalidArgumentError(
                f"history: {text!r} given; last, since-last or N,STRIDE allowed, N at least 2"
            )
        return cls(int(parts[0]), int(parts[1]))


# Names, types and help; the command has the same names (apps/policy_server.cc).
OPTIONS = {
    "keys": ("NAME|FILE.json", "preset of keys: mikasa (default), libero, droid, openvla, oft"),
    "state": (
        "LAYOUT",
        "state as tcp7, tcp7_continuous, libero8, libero_rpy8, oxe8 or joints8; default: the "
        "keys' own",
    ),
    "actions": ("NAME", "what actions mean: mikasa, libero or oxe; default: the keys' own"),
    "image": ("N|HxW|native", "size of images; default: the server's or the keys' own"),
    "replan": ("N", "actions of a chunk that are used; default: all"),
    "history": ("last|since-last|N,STRIDE", "frames that the server gets; default: last"),
    "reset": ("reconnect|message|none", "how the server learns of a new episode"),
    "wait": ("SECONDS", "time that a server may take to listen, default 10"),
}


@dataclasses.dataclass(frozen=True)
class ServerOptions:
    """What a client needs to know.

    given: options that the user chose, as text, for results.
    """

    url: str
    protocol: str
    host: str
    port: int
    path: str
    keys: str = "mikasa"
    state: str | None = None
    actions: str | None = None
    image: tuple[int, int] | str | None = None  # None: as the keys say; "native"
    replan: int = 0  # 0: all
    history: History = dataclasses.field(default_factory=lambda: History(1))
    reset: str = "none"
    wait: float = 10.0
    timeout: float = 300.0
    given: Mapping[str, str] = dataclasses.field(default_factory=dict)

    @classmethod
    def parse(cls, url: str, timeout: float = 300.0, **options: Any) -> ServerOptions:
        """Options of the URL's query; those in keywords win. None: not given."""
        parts = _split(url)
        given = dict(urllib.parse.parse_qsl(parts.query, keep_blank_values=True))
        given.update({name: str(value) for name, value in options.items() if value is not None})
        unknown = sorted(set(given) - set(OPTIONS))
        if unknown:
            raise InvalidArgumentError(
                f"policy server: option {unknown[0]!r} given, {', '.join(OPTIONS)} allowed"
            )
        values: dict[str, Any] = {name: _READ[name](name, text) for name, text in given.items()}
        try:
            port = parts.port or PORTS[parts.scheme]
        except ValueError:
            raise InvalidArgumentError(
                f"policy server: {url!r} given; a port from 1 to 65535 allowed"
            ) from None
        host = parts.hostname or ""
        shown = f"{parts.scheme}://{bracketed(host)}:{port}{parts.path}"
        values.setdefault("reset", _USUAL_RESET[parts.scheme])
        return cls(
            shown, parts.scheme, host, port, parts.path, timeout=timeout, given=given, **values
        )


def bracketed(host: str) -> str:
    """The host as URLs have it."""
    return f"[{host}]" if ":" in host else host


def is_url(text: Any) -> bool:
    """True for the address of a policy server."""
    return isinstance(text, str) and text.partition("://")[0] in PORTS and "://" in text


def _split(url: str) -> urllib.parse.SplitResult:
    allowed = "|".join(PORTS) + "://HOST:PORT"
    try:
        parts = urllib.parse.urlsplit(url)
    except ValueError:
        raise InvalidArgumentError(f"policy server: {url!r} given, {allowed} needed") from None
    if parts.scheme not in PORTS or not parts.hostname:
        raise InvalidArgumentError(f"policy server: {url!r} given, {allowed} needed")
    if parts.username is not None or parts.fragment:
        raise InvalidArgumentError(
            f"policy server: {url!r} given; no user and no fragment allowed, a key for the server "
            "is read from ENGRAM_SERVER_KEY"
        )
    return parts


def _number(name: str, text: str, low: int, high: int) -> int:
    if not text.isascii() or not text.isdigit() or not low <= int(text[:9]) <= high:
        raise InvalidArgumentError(f"{name}: {text!r} given, a whole number {low} to {high} needed")
    return int(text)


def _image(name: str, text: str) -> tuple[int, int] | str:
    if text == "native":
        return text
    sides = text.split("x") if "x" in text else [text, text]
    if len(sides) != 2:
        raise InvalidArgumentError(f"{name}: {text!r} given; N, HxW or native allowed")
    return _number(name, sides[0], 8, 4096), _number(name, sides[1], 8, 4096)


def _reset(name: str, text: str) -> str:
    if text not in RESETS:
        raise InvalidArgumentError(f"{name}: {text!r} given, {', '.join(RESETS)} allowed")
    return text


def _word(name: str, text: str) -> str:
    if not text:
        raise InvalidArgumentError(f"{name}: '' given, a name needed")
    return text


_READ: dict[str, Any] = {
    "keys": _word,
    "state": _word,
    "actions": _word,
    "image": _image,
    "replan": lambda name, text: _number(name, text, 1, limits.ACTIONS),
    "history": lambda _, text: History.parse(text),
    "reset": _reset,
    "wait": lambda name, text: float(_number(name, text, 0, 86400)),
}


def replan_of(text: str | None) -> int:
    """Actions of a chunk that are used; 0: all."""
    return 0 if text is None else int(_READ["replan"]("replan", text))


def flag_of(name: str) -> str:
    """The option of the command line."""
    return f"--{name}" if name in ("replan", "history") else f"--server-{name}"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options to a parser of Python's."""
    for name, (kind, text) in OPTIONS.items():
        parser.add_argument(flag_of(name), dest=f"server_{name}", metavar=kind, help=text)


_BRIDGE = "import sys; sys.path[:] = [p for p in sys.path if p]; " + (
    "from engram.servers.__main__ import run; run()"
)


def bridge_command(parsed: argparse.Namespace) -> str:
    """A command that implements the pipe protocol by asking ``parsed.policy_server``."""
    given: dict[str, Any] = dict(given_arguments(parsed))
    ServerOptions.parse(parsed.policy_server, **given)  # refuses bad ones now
    words = [sys.executable, "-c", _BRIDGE, "bridge", parsed.policy_server]
    words.append(f"--timeout={parsed.policy_timeout}")
    words += [f"{flag_of(name)}={value}" for name, value in given.items()]
    return "exec " + shlex.join(words)


def given_arguments(parsed: argparse.Namespace) -> dict[str, str]:
    """Those that were given, by name."""
    values = {name: getattr(parsed, f"server_{name}") for name in OPTIONS}
    return {name: value for name, value in values.items() if value is not None}
