"""A client that gets whole chunks, as the server sends them, and can change what it sends."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import numpy.typing as npt

from engram.servers.checking.recording import Recording, states_of
from engram.servers.frames import Frame
from engram.servers.policy import ServerPolicy

Array = npt.NDArray[Any]


class Asker(ServerPolicy):
    """Asks in every step.

    Args:
        url, action_dim, timeout, **options: As of ServerPolicy. Whatever ``actions`` is, answers
            stay as they are.
        tell: The server learns of the episode, as by ``--tell-episodes``.

    Attributes:
        convention: What ``actions`` or the keys say.
        questions: How many answers there were.
    """

    def __init__(self, url: str, *, tell: bool = False, **options: Any) -> None:
        meant = ServerPolicy(url, **options)
        self.convention = meant.keys.convention
        self.tell = tell
        self.questions = 0
        self._states: dict[tuple[str, int], Array] = {}
        self._chunk: Array = np.zeros((0, 0), np.float32)
        super().__init__(url, **{**options, "actions": "mikasa", "replan": 1})

    def ask(
        self,
        recording: Recording,
        step: int,
        *,
        first: bool = True,
        states: Array | None = None,
        **changes: Any,
    ) -> Array:
        """The whole answer (K, A) to a step of a recording.

        Args:
            recording: An episode.
            step: Of it.
            first: An episode begins with this question.
            states: Those to be sent, (T, W); None: in the layout of the keys.
            **changes: Other values of the observation, such as ``rgb``.
        """
        seen = recording.observation(step, first=first, tell=self.tell)
        if self.keys.state:
            seen["sent_state"] = (self.states(recording) if states is None else states)[step]
        self({**seen, **changes})
        return self._chunk

    def states(self, recording: Recording) -> Array:
        """States of an episode in the layout of the keys, (T, W)."""
        name = recording.env_id, recording.seed
        if name not in self._states:
            self._states[name] = states_of(self.keys.layout, recording.proprio)
        return self._states[name]

    def _frame(self, last: Frame | None, observation: dict[str, Any], row: int) -> Frame:
        frame = super()._frame(last, observation, row)
        if "sent_state" not in observation:
            return frame
        return dataclasses.replace(frame, state=observation["sent_state"])

    async def _exchange(self, slot: Any, question: Any) -> Array:
        self._chunk = await super()._exchange(slot, question)
        self.questions += 1
        return self._chunk
