"""Chunks and histories for policies in Python, as policy servers have them."""

from __future__ import annotations

import collections
import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from engram.errors import InvalidArgumentError
from engram.servers.frames import FrameHistory
from engram.servers.options import History

Array = npt.NDArray[Any]
_PARTS = ("rgb", "state", "proprio", "step")  # of a frame


@dataclasses.dataclass
class _Episode:
    history: FrameHistory[dict[str, Array]]
    queue: collections.deque[Array] = dataclasses.field(default_factory=collections.deque)


class ChunkedPolicy:
    """Cuts the chunks of a policy, and shows it the frames between its questions.

    Args:
        policy: Answers observations of engram.evaluate with a chunk (K, A) for each episode. Unless
            the history is "last", observations also have ``frames``: a dict for each episode, with
            ``rgb``, ``state``, ``proprio`` and ``step`` over time, the oldest first.
        replan: Actions of a chunk that are used; 0: all.
        history: "last", "since-last" or "N,STRIDE".

    With another history than "last" it has to be called in every step, and answers with one action.
    """

    def __init__(
        self, policy: Callable[[dict[str, Any]], list[Array]], replan: int, history: str
    ) -> None:
        self._policy = policy
        self._replan = replan
        self._history = History.parse(history)
        self._episodes: dict[tuple[int, int], _Episode] = {}

    def __call__(self, observation: dict[str, Any]) -> list[Array]:
        """Chunks of actions, (K, A) each."""
        if self._history.is_last:
            return [self._cut(chunk) for chunk in self._policy(observation)]
        episodes = [self._episode_of(observation, row) for row in range(len(observation["slot"]))]
        for row, episode in enumerate(episodes):
            parts = {name: observation[name] for name in _PARTS}
            episode.history.add({k: v[row] for k, v in parts.items() if v is not None})
        asked = [row for row, episode in enumerate(episodes) if not episode.queue]
        if asked:
            question = _rows(observation, asked)
            question["frames"] = [_over_time(episodes[row].history.take()) for row in asked]
            for row, chunk in zip(asked, self._policy(question)):
                episodes[row].queue.extend(self._cut(chunk))
        return [episode.queue.popleft()[None] for episode in episodes]

    def _cut(self, chunk: Array) -> Array:
        actions = chunk.reshape(-1, chunk.shape[-1])
        if len(actions) < self._replan:
            raise InvalidArgumentError(
                f"policy: a chunk of {len(actions)} given; replan={self._replan} needs as many"
            )
        return actions[: self._replan or None]

    def _episode_of(self, observation: dict[str, Any], row: int) -> _Episode:
        name = int(observation["worker"]), int(observation["slot"][row])
        if observation["first"][row] or name not in self._episodes:
            self._episodes[name] = _Episode(FrameHistory(self._history))
        return self._episodes[name]


def _rows(observation: dict[str, Any], rows: list[int]) -> dict[str, Any]:
    """The observation of some of its episodes."""
    count = len(observation["slot"])
    result: dict[str, Any] = {}
    for name, value in observation.items():
        if isinstance(value, np.ndarray) and value.ndim > 0 and len(value) == count:
            result[name] = value[rows]
        elif isinstance(value, (list, tuple)):
            result[name] = [value[row] for row in rows]
        else:
            result[name] = value
    return result


def _over_time(frames: list[dict[str, Array]]) -> dict[str, Array | None]:
    return {
        name: np.stack([frame[name] for frame in frames]) if name in frames[0] else None
        for name in _PARTS
    }
