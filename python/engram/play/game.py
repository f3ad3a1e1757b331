"""An episode that a person plays.

What the page is told before the end is what the robot could tell: pictures and the number of the
step. Rewards, answers and the like stay here until then.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from engram.play import pictures
from engram.play.episode_spec import Setting

VIEWS = ((640, 480), (480, 360), (320, 240))  # the largest that the machine draws in time


class Game:
    """One episode at a time, as demonstrations are played: it ends at success.

    The human view is drawn as an observation, by a batch that gets snapshots: so it has nothing
    that is painted for people only, such as the place to which a cube has to come back.
    """

    def __init__(self, setting: Setting) -> None:
        self.setting = setting
        self._env = setting.batch(obs_mode="rgb", terminate_on_success=True)
        self.description: Any = self._env.description
        self._view: Any = None
        self._size = -1
        self.resize(0)
        self.start(setting)

    def resize(self, size: int) -> None:
        """Draws the human view in another size from now on."""
        if size == self._size:
            return
        if self._view is not None:
            self._view.close()
        self._size = size
        self._view = self.setting.batch(
            obs_mode="rgb",
            terminate_on_success=True,
            cameras=["render_camera"],
            image_size=VIEWS[size],
            antialias=True,
        )
        self._view.reset(seed=0)

    @property
    def size(self) -> int:
        """Which of VIEWS."""
        return self._size

    def start(self, setting: Setting) -> None:
        """Begins an episode of the same kind of setting."""
        self.setting = setting
        self._observation, _ = setting.reset(self._env)
        self.instruction = self._env.instructions[0]
        self.elapsed = 0
        self.ended = False
        self.actions: list[npt.NDArray[np.float32]] = []
        self.rewards: list[float] = []
        self._info: dict[str, Any] = {}
        self._truncated = False

    def step(self, action: list[float]) -> None:
        """One control step, unless the episode has ended."""
        if self.ended:
            return
        row = np.clip(np.array(action, np.float32), -1, 1)
        self._observation, reward, terminated, truncated, self._info = self._env.step(row[None])
        self.actions.append(row)
        self.rewards.append(float(reward[0]))
        self.elapsed += 1
        self._truncated = bool(truncated[0])
        self.ended = bool(terminated[0]) or self._truncated

    def picture(self, acted: int) -> bytes:
        """The message that shows the scene now. acted: number of the input that moved it last."""
        view, _ = self._view.restore(self._env.save(0), 0)
        return pictures.packed(
            {"kind": "play", "n": self.elapsed, "input": acted, "ended": self.ended},
            pictures.jpeg(view["rgb"][0]),
            pictures.sensors(self._observation["rgb"][0]),
        )

    def result(self) -> dict[str, Any]:
        """How it went; known when it has ended."""
        info = self._info

        def told(name: str) -> bool | None:
            return bool(info[name][0]) if name in info else None

        answered = told("answered")
        return {
            "success": bool(info["success_once"][0]),
            "failed": told("failed"),
            "truncated": self._truncated,
            "answered": answered,
            "first_answer_correct": told("first_answer_correct") if answered else None,
            "return": float(info["episode_return"][0]),
            "steps": self.elapsed,
            "seed": str(self.setting.seed),
        }

    def close(self) -> None:
        self._env.close()
        self._view.close()
