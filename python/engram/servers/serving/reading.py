"""Requests of clients as a policy takes them: the keys of a preset, read backwards."""

from __future__ import annotations

import asyncio
import collections
import concurrent.futures
import heapq
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from engram.servers.conventions import from_engram
from engram.servers.keys import Keys
from engram.servers.serving.policies import Request, RequestError, ServedPolicy

Array = npt.NDArray[Any]


_MOST_NAMES = 1024


class Sessions:
    """Numbers of sessions; those of ended and of long unused sessions are given again."""

    def __init__(self) -> None:
        self._free: list[int] = []
        self._count = 0
        self._named: collections.OrderedDict[str, int] = collections.OrderedDict()
        self._begun: set[int] = set()

    def new(self) -> int:
        """The smallest number that is free."""
        if self._free:
            return heapq.heappop(self._free)
        self._count += 1
        return self._count - 1

    def end(self, session: int) -> None:
        self.begin(session)
        heapq.heappush(self._free, session)

    def of(self, name: Any) -> int:
        """The session of that name; requests without one share one."""
        text = str(name)[:200]
        if text not in self._named:
            if len(self._named) >= _MOST_NAMES:
                self.end(self._named.popitem(last=False)[1])
            self._named[text] = self.new()
        self._named.move_to_end(text)
        return self._named[text]

    def begin(self, session: int) -> None:
        """The next request of the session is the first of an episode."""
        self._begun.discard(session)

    def is_first(self, session: int) -> bool:
        """True once for each episode."""
        first = session not in self._begun
        self._begun.add(session)
        return first


class Reader:
    """Reads requests by the keys of a preset, and asks the policy."""

    def __init__(self, policy: ServedPolicy, keys: Keys) -> None:
        self.policy = policy
        self.keys = keys
        self.sessions = Sessions()
        self._thread = concurrent.futures.ThreadPoolExecutor(1)

    async def answer(self, *request: Any) -> Array:
        """Actions (K, 7) in the convention of the keys; the loop goes on while they are computed.

        Args:
            *request: session, images, state, prompt, episode.
        """
        loop = asyncio.get_running_loop()
        return await loop.run_in_executor(self._thread, self._answer, *request)

    def _answer(
        self,
        session: int,
        images: Mapping[str, Any],
        state: Mapping[str, Any],
        prompt: Any,
        episode: Any,
    ) -> Array:
        keys = self.keys
        base, wrist = _frames(images, keys.base, 3), _frames(images, keys.wrist, 3)
        rgb: Array | None = None
        if base is not None and wrist is not None:
            if base.shape != wrist.shape or base.dtype != np.uint8 or wrist.dtype != np.uint8:
                raise RequestError("images of one size, uint8, needed from both cameras")
            rgb = np.concatenate([base, wrist], -1)
        proprio: Array | None = None
        parts = [_frames(state, name, 1) for name in keys.state]
        known = [part for part in parts if part is not None]
        if keys.layout in ("tcp7", "joints8") and known and len(known) == len(parts):
            proprio = np.concatenate(known, -1)
        request = Request(
            session,
            self.sessions.is_first(session),
            rgb,
            proprio,
            _frames(state, keys.row, 1),
            prompt if isinstance(prompt, str) else "",
            episode if isinstance(episode, Mapping) else None,
        )
        actions = from_engram(keys.convention, self.policy.answer(request))
        return np.ascontiguousarray(actions, np.float32)


def _frames(values: Mapping[str, Any], name: str | None, axes: int) -> Array | None:
    """An array with a time axis before the others."""
    if name is None or values.get(name) is None:
        return None
    array = np.asarray(values[name])
    if array.ndim not in (axes, axes + 1) or array.dtype.kind not in "biuf":
        raise RequestError(f"{name}: shape {array.shape} given, {axes} axes or one more needed")
    return array if array.ndim > axes else array[None]
