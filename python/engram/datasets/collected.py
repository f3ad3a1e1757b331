"""Episodes of ``engram collect`` as they are played, without files between."""

from __future__ import annotations

import functools
import io
import itertools
import struct
import subprocess
from collections.abc import Callable, Collection, Iterator
from typing import Any

from engram.datasets import additions, checks, frozen
from engram.datasets.checks import DatasetError
from engram.datasets.episodes import DemonstrationFolder, Episode, read_metadata
from engram.datasets.spaces import Spaces

_LARGEST_BLOCK = 1 << 32  # bytes


class CollectedEpisodes:
    """Stands for a ``DemonstrationFolder``: plays the episodes of one task while they are iterated.

    Args:
        command: The engram command.
        env_id: The task.
        words: Options of ``engram collect``.
        episodes: How many are collected.
        spaces: Those that the options ask for.
        additions: What they ask for beside colours, proprio and actions.
        keeps_failures: Whether they keep episodes that fail.

    ``metadata`` and ``metadata_bytes`` are there after the last episode. For use with ``with``: at
    the end the command is stopped.
    """

    metadata: dict[str, Any]
    metadata_bytes: bytes

    def __init__(
        self,
        command: str,
        env_id: str,
        words: list[str],
        episodes: int,
        spaces: Spaces,
        additions: frozenset[str] = frozenset(),
        keeps_failures: bool = False,
    ) -> None:
        self.env_id = env_id
        self.spaces = spaces
        self.words = words
        self.additions = additions
        self.keeps_failures = keeps_failures
        self._episodes = episodes
        self._ahead: list[Episode] = []  # read, but not given out yet
        self._command = [command, "collect", env_id, "--stream", *words]

    def __enter__(self) -> CollectedEpisodes:
        self._process = subprocess.Popen(self._command, stdout=subprocess.PIPE)
        assert self._process.stdout is not None
        self._source = self._process.stdout
        self._unread = self._read_episodes()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Stops the command, if it runs."""
        self._process.kill()  # it writes no files, and has nothing to say
        self._source.close()
        self._process.wait()

    def __len__(self) -> int:
        return self._episodes

    @property
    def origin(self) -> dict[str, Any]:
        """How the episodes are made, as far as the options say it."""
        return frozen.origin_of_words(self.words)

    def __getitem__(self, index: slice) -> list[Episode]:
        """The first episodes, ahead of the iteration."""
        more = index.stop - len(self._ahead)
        self._ahead += itertools.islice(self._unread, max(more, 0))
        return self._ahead[index]

    def require(self, asked: Collection[str]) -> None:
        """Nothing to refuse: additions are collected where they are asked for."""

    def __iter__(self) -> Iterator[Episode]:
        while self._ahead:
            yield self._ahead.pop(0)
        yield from self._unread
        self._finish()

    def loaders(self) -> Iterator[Callable[[], Episode]]:
        """Functions that read the episodes, for threads."""
        yield from self._read_blocks()
        self._finish()

    def _read_episodes(self) -> Iterator[Episode]:
        for load in self._read_blocks():
            yield load()

    def _read_blocks(self) -> Iterator[Callable[[], Episode]]:
        while block := self._block():
            yield functools.partial(self._load, block)

    def _load(self, block: bytes) -> Episode:
        return Episode.load(io.BytesIO(block), self.spaces, self.additions)

    def _finish(self) -> None:
        self.metadata_bytes = self._block()
        self.metadata = read_metadata(self.metadata_bytes)
        if self._process.wait() != 0:  # it has said why
            raise DatasetError(f"{self.env_id}: engram collect failed")

    def _block(self) -> bytes:
        """The next block: its length, 8 bytes, little-endian, and that many bytes."""
        head = self._source.read(8)
        size = struct.unpack("<Q", head)[0] if len(head) == 8 else None
        if size is None or size > _LARGEST_BLOCK:
            raise DatasetError(f"{self.env_id}: engram collect ended too early")
        body = self._source.read(size)
        if len(body) != size:
            raise DatasetError(f"{self.env_id}: engram collect ended too early")
        return body


# Where converters take episodes from.
EpisodeSource = DemonstrationFolder | CollectedEpisodes


def add_arguments(parser: Any) -> None:
    """What a task is collected with."""
    parser.add_argument("--command", required=True, help="the engram command")
    parser.add_argument("--episodes", type=int, required=True)
    parser.add_argument("--control-mode", default=Spaces.control_mode)
    parser.add_argument("--joint-proprio", action="store_true")
    parser.add_argument("--keep-failures", action="store_true")
    parser.add_argument(
        "--word", action="append", default=[], dest="words", help="another word of the command"
    )


def collect(options: Any, env_id: str) -> CollectedEpisodes:
    """The episodes of a task by the arguments of ``add_arguments`` and the words behind them."""
    checks.env_id("env_id", env_id)
    spaces = Spaces(options.control_mode, options.joint_proprio)
    words = ["--episodes", str(options.episodes), "--control-mode", options.control_mode]
    words += ["--joint-proprio"] * options.joint_proprio
    asked = [name for name in additions.ADDITIONS if getattr(options, name)]
    words += [f"--{name}" for name in asked]
    words += ["--keep-failures"] * options.keep_failures + options.words
    return CollectedEpisodes(
        options.command,
        env_id,
        words,
        options.episodes,
        spaces,
        frozenset(asked),
        options.keep_failures,
    )
