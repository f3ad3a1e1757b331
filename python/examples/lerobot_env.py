"""engram inside LeRobot's evaluation loop.

LeRobot's rollout wants a vector environment whose observations are {"pixels": {camera: images},
"agent_pos": state}, which tells tasks through `envs[i].task_description`, and whose final infos
hold "is_success". This file is such a module as its EnvHub loads (`make_env`), and can be used
directly too:

    from lerobot_env import make_env
    envs = make_env(n_envs=10, task="RememberColor3-VLA-v0")  # {"engram": {0: vector env}}

The names of images and state are those of the LeRobot data sets that engram's demonstrations are
converted to: observation.images.top, observation.images.wrist, observation.state.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.vector import VectorEnv, VectorWrapper
from gymnasium.vector.utils import batch_space

import engram


class LeRobotEnv(VectorWrapper):
    """Renames observations; says in final infos whether the episode succeeded at any time."""

    def __init__(self, env: engram.VectorEnv) -> None:
        super().__init__(env)
        single = env.single_observation_space
        image = spaces.Box(0, 255, (*single["rgb"].shape[:2], 3), np.uint8)
        self.single_observation_space = spaces.Dict(
            {
                "pixels": spaces.Dict({"top": image, "wrist": image}),
                "agent_pos": single["proprio"],
            }
        )
        self.observation_space = batch_space(self.single_observation_space, env.num_envs)

    @property
    def envs(self) -> list[Any]:
        """One object per environment: task, task_description, render(), ...."""
        return self.env.envs

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """An attribute or method of each of ``envs``."""
        return self.env.call(name, *args, **kwargs)

    def reset(self, *, seed: Any = None, options: Any = None) -> tuple[dict[str, Any], Any]:
        """As of ``engram.VectorEnv``."""
        obs, info = self.env.reset(seed=seed, options=options)
        return self._renamed(obs), info

    def step(self, actions: Any) -> tuple[Any, ...]:
        """As of ``engram.VectorEnv``; actions beyond [-1, 1] are clipped by the controller."""
        obs, reward, terminated, truncated, info = self.env.step(actions)
        if "final_info" in info:
            final = info["final_info"]
            final["is_success"] = final["success_once"] & info["_final_info"]
        return self._renamed(obs), reward, terminated, truncated, info

    def _renamed(self, obs: dict[str, np.ndarray]) -> dict[str, Any]:
        rgb = obs["rgb"]
        return {
            "pixels": {"top": rgb[..., :3], "wrist": rgb[..., 3:]},
            "agent_pos": obs["proprio"],
        }


def make_env(
    n_envs: int = 1,
    use_async_envs: bool = False,
    cfg: Any = None,
    task: str = "RememberColor3-VLA-v0",
) -> dict[str, dict[int, VectorEnv]]:
    """What EnvHub calls: {suite: {task number: vector environment}}."""
    task = getattr(cfg, "task", None) or task
    env = engram.make_vec(
        task,
        n_envs,
        obs_mode="rgb",
        autoreset_mode="SAME_STEP",  # what LeRobot makes its own environments with
        copy=True,  # its rollout keeps what it gets
    )
    return {"engram": {0: LeRobotEnv(env)}}
