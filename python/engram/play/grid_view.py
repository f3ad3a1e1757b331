"""Sixteen environments at once."""

from __future__ import annotations

from typing import Any

import numpy as np

from engram.play import pictures
from engram.play.playback import Player
from engram.play.episode_spec import Setting

COLUMNS = 4
ENVS = COLUMNS * COLUMNS
_SIZE = (192, 144)
_PAUSE = 30  # steps that the last pictures stay


class Wall:
    """Episodes of seeds one after the other; when the last has ended, the next sixteen begin."""

    def __init__(self, setting: Setting, player: Player, obs_mode: Any) -> None:
        self._setting = setting
        self._player = player
        self._env = setting.batch(ENVS, obs_mode=obs_mode, threads=0)
        self._played = 0
        self._succeeded = 0
        self.steps = 0
        self._begin(setting.seed)

    def _begin(self, seed: int) -> None:
        self._seed = seed
        self._setting.reset(self._env, seed)
        self._first = True
        self._left = _PAUSE
        self._elapsed = 0
        self._success = np.zeros(ENVS, bool)
        self._over = np.zeros(ENVS, bool)

    def step(self) -> None:
        """One step of all, or of none while the end of an episode is looked at."""
        self.steps += 1
        if self._over.all():
            self._left -= 1
            if self._left <= 0:
                self._played += ENVS
                self._succeeded += int(self._success.sum())
                self._begin((self._seed + ENVS) % 2**63)
            return
        _, _, terminated, truncated, info = self._env.step(self._player(self._env, self._first))
        self._first = False
        self._elapsed += 1
        self._success = info["success_once"].astype(bool)
        self._over = terminated | truncated

    def picture(self) -> bytes:
        """The message that shows all of them."""
        views = [self._env.frame(i, "render_camera", _SIZE) for i in range(ENVS)]
        return pictures.packed(
            {
                "kind": "wall",
                "n": self.steps,
                "elapsed": self._elapsed,
                "seed": str(self._seed),
                "success": self._success.tolist(),
                "over": self._over.tolist(),
                "played": self._played,
                "succeeded": self._succeeded,
            },
            pictures.jpeg(pictures.mosaic(views, COLUMNS), 85),
        )

    def close(self) -> None:
        self._env.close()
