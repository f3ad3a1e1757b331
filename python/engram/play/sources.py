"""Policies and folders to watch, from the command line only, never from the page."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from engram.play.folders import BUILTIN, PROCESS, Recording, SourceError, open_folder
from engram.play.playback import Policy
from engram.play.policy_process import PolicyError, PolicyProcess

_GRACE = 2.0  # seconds for an answer that is no longer wanted


def builtin_policy(policy: str) -> Policy:
    """One of engram's own policies."""

    def act(env: Any, _first: bool) -> npt.NDArray[np.float32]:
        actions: npt.NDArray[np.float32] = env.act(policy)
        return np.clip(actions, -1, 1)

    return act


class Sources:
    """Policies by name and folders by number, for the page to choose from."""

    def __init__(
        self, folders: list[Path], command: str | None, obs: str, timeout: float, num_envs: int
    ) -> None:
        self._folders = [open_folder(path) for path in folders]
        self._command = command
        self._obs = obs
        self._timeout = timeout
        self._num_envs = num_envs
        self._process: PolicyProcess | None = None
        self._closing = threading.Lock()  # the engine's thread and the server end the process

    def message(self) -> dict[str, Any]:
        """The choices, for the page."""
        names = [*BUILTIN, *([PROCESS] if self._command is not None else [])]
        return {"sources": names, "folders": [folder.message() for folder in self._folders]}

    def policy(self, name: str) -> tuple[Policy, str]:
        """The policy of that name, and the observation mode that it needs."""
        if name == PROCESS and self._command is not None:
            return self._act, self._obs
        if name not in BUILTIN:
            raise SourceError(
                f"no policy '{name}'; there are: {', '.join(self.message()['sources'])}"
            )
        return builtin_policy(name), "state"

    def _act(self, env: Any, first: bool) -> npt.NDArray[np.float32]:
        """Actions of the process, which is started if there is none."""
        if self._process is None:
            if not first or self._command is None:
                raise PolicyError("the policy's process has ended; begin the episode again")
            self._process = PolicyProcess(self._command, self._obs, self._num_envs, self._timeout)
        try:
            return self._process.act(env, first)
        except PolicyError:
            self.close()  # the next episode starts a new one
            raise

    def shorten_deadline(self, seconds: float = _GRACE) -> None:
        """The answer that is waited for is no longer wanted; from any thread."""
        process = self._process
        if process is not None:
            process.shorten_deadline(seconds)

    def recording(self, folder: int, task: int, episode: int) -> Recording:
        """An episode of a folder."""
        if folder >= len(self._folders):
            raise SourceError(f"no folder {folder}; there are {len(self._folders)}")
        return self._folders[folder].recording(task, episode, self.policy)

    def close(self) -> None:
        """Ends the policy's process; from any thread."""
        with self._closing:
            if self._process is not None:
                self._process.close()
                self._process = None
