"""Server of `engram play` in a process of its own, and a client for its tests."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import signal
import struct
import subprocess
import sys
import urllib.request
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from engram.play.episode_spec import EpisodeSpec

SECONDS = 60  # limit for every wait


@dataclasses.dataclass
class Server:
    """A running server."""

    link: str
    out: Path
    process: subprocess.Popen[str]

    @property
    def host(self) -> str:
        return urlsplit(self.link).netloc

    @property
    def token(self) -> str:
        return urlsplit(self.link).path.strip("/")

    def get(self, path: str) -> Any:
        """A JSON file of the page's."""
        with urllib.request.urlopen(self.link + path, timeout=SECONDS) as answer:
            return json.load(answer)

    def refused(self) -> dict[str, int]:
        """Numbers of refused requests, by reason."""
        counts: dict[str, int] = self.get("refused.json")
        return counts

    @contextlib.contextmanager
    def page(self, **more: Any) -> Iterator[Page]:
        """A tab without a browser."""
        address = self.link.replace("http:", "ws:") + "socket"
        given: Any = {"origin": f"http://{self.host}", "max_size": 1 << 24, **more}
        with connect(address, **given) as socket:
            yield Page(socket)

    def end(self) -> str:
        """Ends it as Ctrl-C does; returns its standard error."""
        self.process.send_signal(signal.SIGINT)
        return self.process.communicate(timeout=SECONDS)[1]


class Page:
    """A client in place of the page."""

    def __init__(self, socket: ClientConnection) -> None:
        self.socket = socket
        self.received: list[dict[str, Any]] = []  # messages, and headers of pictures
        self.files: list[bytes] = []  # of the last picture

    def send(self, kind: str, **fields: Any) -> None:
        self.socket.send(json.dumps({"do": kind, **fields}))

    def receive(self, wanted: str) -> dict[str, Any]:
        """The next message of that type, or picture of that kind; an error ends the test."""
        while True:
            data = self.socket.recv(timeout=SECONDS)
            if isinstance(data, str):
                message = json.loads(data)
                kind = message["type"]
            else:
                (size,) = struct.unpack_from("<I", data)
                message = json.loads(data[4 : 4 + size])
                kind = message["kind"]
                at = 4 + size
                self.files = []
                for length in message["sizes"]:
                    self.files.append(data[at : at + length])
                    at += length
            self.received.append(message)
            if kind == wanted:
                return message
            assert kind != "error", message

    def closed(self) -> int | None:
        """Waits for the end of the connection; returns its code."""
        with contextlib.suppress(ConnectionClosed):
            while True:
                self.socket.recv(timeout=SECONDS)
        return self.socket.close_code

    def play(self, id: str, seed: int | None = None, **more: Any) -> dict[str, Any]:
        """Begins an episode; returns the first message."""
        self.send("play", id=id, seed=None if seed is None else str(seed), **more)
        opened = self.receive("opened")
        self.receive("play")
        return opened

    def step(self, action: Any, number: int = 0) -> dict[str, Any]:
        """One step of a paused episode; returns the picture's header."""
        self.send("step", a=[float(value) for value in action], n=number)
        return self.receive("play")


@contextlib.contextmanager
def serving(
    out: Path,
    *arguments: Any,
    stay: bool = True,
    opens: bool = False,
    program: Sequence[Any] = (sys.executable, "-m"),
    command: Sequence[str] = ("engram.play",),
    cwd: Path | None = None,
) -> Iterator[Server]:
    """A server until the block ends. command: the module to run, and its first arguments."""
    words = [*program, *command, *([] if opens else ["--no-open"]), "--out", out, *arguments]
    with subprocess.Popen(
        [str(word) for word in [*words, *(["--stay"] if stay else [])]],
        cwd=cwd,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            assert process.stdout is not None
            line = process.stdout.readline()
            if not line:
                raise AssertionError(process.communicate()[1])
            yield Server(line.split()[-1], out, process)
        finally:
            process.kill()


def play_oracle(page: Page, id: str, seed: int) -> dict:
    """An episode with the oracle's actions, to its end; returns how it ended."""
    page.play(id, seed)
    mirror = EpisodeSpec(id, seed).make_batch(terminate_on_success=True)
    mirror.reset(seed=seed)
    ended = False
    while not ended:
        action = np.clip(mirror.act("oracle")[0], -1, 1).astype(np.float64)
        ended = page.step(action)["ended"]
        mirror.step(action.astype(np.float32)[None])
    mirror.close()
    return page.receive("ended")
