"""A batch in the form that LeRobot's rollout expects."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.vector import VectorWrapper
from gymnasium.vector.utils import batch_space

from engram.datasets.spaces import ANGLES, CONTROL_MODE, Spaces
from engram.envs.vector_env import VectorEnv
from engram.errors import InvalidArgumentError

CAMERAS = ("top", "wrist")


class LeRobotEnv(VectorWrapper):
    """A batch whose observations are {"pixels": {camera: images}, "agent_pos": proprio}.

    ``envs[i].task_description`` is the instruction, and infos of ended episodes hold
    "is_success": success at any time of the episode. An environment whose episode has ended stands
    still, with its last frame, until ``reset``.

    Args:
        id: Task, such as "RememberColor3-VLA-v0".
        num_envs: Number of environments.
        angles: Of the TCP in agent_pos: "continuous", as data sets have them that
            `python -m engram.datasets lerobot` writes, or as the "benchmark" has them.
        **options: Those of ``VectorEnv``, except obs_mode, autoreset_mode, after_end and copy.
    """

    def __init__(self, id: str, num_envs: int, *, angles: str = ANGLES[0], **options: Any) -> None:
        if angles not in ANGLES:
            raise InvalidArgumentError(f"angles: {angles!r} given, {', '.join(ANGLES)} allowed")
        # LeRobot's rollout steps all until the last one ends, and keeps the arrays.
        given: Any = {"autoreset_mode": "DISABLED", "after_end": "hold", "copy": True, **options}
        batch = VectorEnv(id, num_envs, obs_mode="rgb", **given)
        super().__init__(batch)
        self.batch = batch
        self._angles = angles
        self._ended = np.zeros(num_envs, np.bool_)
        self._spaces = Spaces(
            options.get("control_mode", CONTROL_MODE), bool(options.get("joint_proprio", False))
        )
        single: Any = batch.single_observation_space
        image = spaces.Box(0, 255, (*single["rgb"].shape[:2], 3), np.uint8)
        self.single_observation_space = spaces.Dict(
            {
                "pixels": spaces.Dict(dict.fromkeys(CAMERAS, image)),
                "agent_pos": single["proprio"],
            }
        )
        self.observation_space = batch_space(self.single_observation_space, num_envs)

    @property
    def envs(self) -> list[Any]:
        """One object per environment: task, task_description, render(), ...."""
        return list(self.batch.envs)

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """An attribute or method of each of ``envs``."""
        return self.batch.call(name, *args, **kwargs)

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """An attribute of each of ``envs``."""
        return self.batch.get_attr(name)

    def reset(self, *, seed: Any = None, options: Any = None) -> tuple[dict[str, Any], Any]:
        """See ``engram.VectorEnv.reset``."""
        obs, info = self.batch.reset(seed=seed, options=options)
        self._ended &= ~np.asarray((options or {}).get("reset_mask", True), np.bool_)
        return self._renamed(obs), info

    def step(self, actions: Any) -> tuple[Any, ...]:
        """See ``engram.VectorEnv.step``; actions beyond [-1, 1] are clipped by the controller."""
        obs, reward, terminated, truncated, info = self.batch.step(actions)
        over = terminated | truncated
        ends = over & ~self._ended
        self._ended |= over
        if ends.any():
            final = {"success_once": info["success_once"], "_success_once": ends}
            info["final_info"] = {**final, "is_success": info["success_once"] & ends}
            info["_final_info"] = ends
        return self._renamed(obs), reward, terminated, truncated, info

    def _renamed(self, obs: dict[str, np.ndarray]) -> dict[str, Any]:
        rgb = obs["rgb"]
        pixels = {camera: rgb[..., 3 * i : 3 * i + 3] for i, camera in enumerate(CAMERAS)}
        state = self._spaces.proprio(obs["proprio"], self._angles)
        return {"pixels": pixels, "agent_pos": state}


def make_env(
    n_envs: int = 1,
    use_async_envs: bool = False,
    cfg: Any = None,
    task: str = "RememberColor3-VLA-v0",
) -> dict[str, dict[int, LeRobotEnv]]:
    """Entry point for LeRobot's EnvHub, in the env.py of a repository: {id: {0: batch}}."""
    id = getattr(cfg, "task", None) or task
    return {id: {0: LeRobotEnv(id, n_envs)}}
