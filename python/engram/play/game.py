"""Episode that a person plays.

Before its end, the page gets only what the robot could observe: pictures and the number of the
step. Rewards, answers and the like are sent at the end.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from engram.play import pictures
from engram.play.episode_spec import EpisodeSpec

VIEWS = ((640, 480), (480, 360), (320, 240))  # the machine's speed decides


class Game:
    """One episode at a time, as demonstrations are played: it ends at success.

    The human view is rendered as an observation, by a second batch that restores snapshots: so it
    has no marks for people, such as the position to which a cube has to return.
    """

    def __init__(self, spec: EpisodeSpec) -> None:
        self.spec = spec
        self._env = spec.make_batch(obs_mode="rgb", terminate_on_success=True)
        self.description: Any = self._env.description
        self._view: Any = None
        self._size = -1
        self.resize(0)
        self.start(spec)

    def resize(self, size: int) -> None:
        """Sets the size of the human view."""
        if size == self._size:
            return
        if self._view is not None:
            self._view.close()
        self._size = size
        self._view = self.spec.make_batch(
            obs_mode="rgb",
            terminate_on_success=True,
            cameras=["render_camera"],
            image_size=VIEWS[size],
            antialias=True,
        )
        self._view.reset(seed=0)

    @property
    def size(self) -> int:
        """Index in VIEWS."""
        return self._size

    def start(self, spec: EpisodeSpec) -> None:
        """Begins an episode that the same batch can play."""
        self._observation, _ = spec.reset(self._env)
        self.spec = spec
        self.instruction = self._env.instructions[0]
        if spec.choices:
            self._env.ask(0)
        self.elapsed = 0
        self.ended = False
        self.actions: list[npt.NDArray[np.float32]] = []
        self.rewards: list[float] = []
        self._info: dict[str, Any] = {}
        self._truncated = False

    def question(self) -> dict[str, Any] | None:
        """The question that is to be answered before the episode goes on, or None."""
        if not self.spec.choices or self.ended:
            return None
        question = self._env.question(0)
        return question if question["due"] else None

    def choose(self, choices: list[int]) -> None:
        """Answers the question."""
        self._env.answer(choices, 0)

    def step(self, action: list[float]) -> None:
        """One control step, unless the episode has ended. The action counts without choices."""
        if self.ended:
            return
        if self.spec.choices:
            action = self._env.act("blind")[0]  # the hand of the answer
        row = np.clip(np.array(action, np.float32), -1, 1)
        self._observation, reward, terminated, truncated, self._info = self._env.step(row[None])
        self.actions.append(row)
        self.rewards.append(float(reward[0]))
        self.elapsed += 1
        self._truncated = bool(truncated[0])
        self.ended = bool(terminated[0]) or self._truncated

    def picture(self, acted: int) -> bytes:
        """The message that shows the scene. acted: number of the last input that had an effect."""
        view, _ = self._view.restore(self._env.save(0), 0)
        return pictures.packed(
            {"kind": "play", "n": self.elapsed, "input": acted, "ended": self.ended},
            pictures.jpeg(view["rgb"][0]),
            pictures.sensors(self._observation["rgb"][0]),
        )

    def result(self) -> dict[str, Any]:
        """The result of the ended episode."""
        info = self._info

        def flag(name: str) -> bool | None:
            return bool(info[name][0]) if name in info else None

        answered = flag("answered")
        return {
            "success": bool(info["success_once"][0]),
            "failed": flag("failed"),
            "truncated": self._truncated,
            "answered": answered,
            "first_answer_correct": flag("first_answer_correct") if answered else None,
            "return": float(info["episode_return"][0]),
            "steps": self.elapsed,
            "seed": str(self.spec.seed),
        }

    def close(self) -> None:
        self._env.close()
        self._view.close()
