"""One environment as a gymnasium.Env."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np

from engram._arguments import checked_actions
from engram._spaces import take
from engram.errors import InvalidArgumentError
from engram.vector_env import VectorEnv


class Env(gymnasium.Env):
    """One environment: a batch of one, for code that cannot use batches.

    What ``reset`` and ``step`` return are copies. Episodes end where the task says (``terminated``)
    or at its horizon (``truncated``); then call ``reset``.

    Args:
        id: Task, such as "RememberColor9-VLA-v0".
        threads: 1, unless the environment is to be drawn by several.
        **options: Those of ``VectorEnv``, except num_envs, autoreset_mode and copy.
    """

    def __init__(self, id: str, *, threads: int = 1, **options: Any) -> None:
        for name in ("num_envs", "autoreset_mode", "copy"):
            if name in options:
                raise InvalidArgumentError(
                    f"{name}: {options[name]!r} given to a single environment"
                )
        options.setdefault("render_mode", None)
        self.batch = VectorEnv(
            id, num_envs=1, threads=threads, autoreset_mode="DISABLED", **options
        )
        self._arguments = {"id": id, "threads": threads, **options}
        self.observation_space = self.batch.single_observation_space
        self.action_space: Any = self.batch.single_action_space
        self.render_mode = self.batch.render_mode
        self.metadata = {"render_modes": ["rgb_array"], "render_fps": 20}

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Starts a new episode; ``options``: "pins" and "constants". See ``VectorEnv.reset``."""
        super().reset(seed=seed)
        self.batch.reset(seed=seed, options=options)
        return self._observation(), self._info()

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """One control step (0.05 s). action: (action_dim,). See ``VectorEnv.step``."""
        array = checked_actions(action, self.action_space.shape)
        self.batch.step(array[np.newaxis])
        views = self.batch._views
        return (
            self._observation(),
            float(views["reward"][0]),
            bool(views["terminated"][0]),
            bool(views["truncated"][0]),
            self._info(),
        )

    def act(self, policy: str = "oracle") -> np.ndarray:
        """An action for the next step, (action_dim,). See ``VectorEnv.act``."""
        return self.batch.act(policy)[0]

    def render(self) -> np.ndarray | None:
        """A picture, uint8 (height, width, 3); None without a render mode."""
        return None if self.render_mode is None else self.batch.frame(0)

    def save(self) -> bytes:
        """The environment, bit-exactly."""
        return self.batch.save(0)

    def restore(self, data: bytes) -> tuple[Any, dict[str, Any]]:
        """Restores what ``save`` returned; returns the observation and infos at that point."""
        self.batch.restore(data, 0)
        return self._observation(), self._info()

    @property
    def language_instruction(self) -> str:
        """The instruction of the running episode."""
        return self.batch.envs[0].language_instruction

    task_description = language_instruction  # LeRobot's name for it

    @property
    def task(self) -> str:
        """Id of the task."""
        return self.batch.task_id

    @property
    def _max_episode_steps(self) -> int:
        return self.batch.envs[0].max_episode_steps

    def close(self) -> None:
        """Ends the environment."""
        self.batch.close()

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickling keeps the specification: the copy is new, not yet reset."""
        return _remake, (self._arguments,)

    def __deepcopy__(self, memo: dict[int, Any]) -> Env:
        return _remake(self._arguments)

    def _observation(self) -> Any:
        return take(self.batch._observation, 0)

    def _info(self) -> dict[str, Any]:
        return self.batch._infos.row(0)


def _remake(arguments: dict[str, Any]) -> Env:
    return Env(**arguments)
