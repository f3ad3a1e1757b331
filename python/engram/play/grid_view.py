"""Grid of sixteen environments that run at once."""

from __future__ import annotations

from typing import Any

import numpy as np

from engram.play import pictures
from engram.play.episode_spec import EpisodeSpec
from engram.play.playback import Policy

COLUMNS = 4
ENVS = COLUMNS * COLUMNS
_SIZE = (192, 144)
_PAUSE = 30  # steps for which the last pictures stay


class GridView:
    """Episodes with consecutive seeds; when all have ended, the next sixteen begin."""

    def __init__(self, spec: EpisodeSpec, policy: Policy, obs_mode: Any) -> None:
        self._spec = spec
        self._policy = policy
        self._env = spec.make_batch(ENVS, obs_mode=obs_mode, threads=0)
        self._played = 0
        self._succeeded = 0
        self.steps = 0
        self._begin(spec.seed)

    def _begin(self, seed: int) -> None:
        self._seed = seed
        self._spec.reset(self._env, seed)
        self._first = True
        self._left = _PAUSE
        self._elapsed = 0
        self._success = np.zeros(ENVS, bool)
        self._ended = np.zeros(ENVS, bool)

    def step(self) -> None:
        """One step of all environments, or a pause after the last episode has ended."""
        self.steps += 1
        if self._ended.all():
            self._left -= 1
            if self._left <= 0:
                self._played += ENVS
                self._succeeded += int(self._success.sum())
                self._begin((self._seed + ENVS) % 2**63)
            return
        _, _, terminated, truncated, info = self._env.step(self._policy(self._env, self._first))
        self._first = False
        self._elapsed += 1
        self._success = info["success_once"].astype(bool)
        self._ended = terminated | truncated

    def picture(self) -> bytes:
        """The message that shows all environments."""
        views = [self._env.frame(i, "render_camera", _SIZE) for i in range(ENVS)]
        return pictures.packed(
            {
                "kind": "grid",
                "n": self.steps,
                "elapsed": self._elapsed,
                "seed": str(self._seed),
                "success": self._success.tolist(),
                "ended": self._ended.tolist(),
                "played": self._played,
                "succeeded": self._succeeded,
            },
            pictures.jpeg(pictures.mosaic(views, COLUMNS), 85),
        )

    def close(self) -> None:
        self._env.close()
