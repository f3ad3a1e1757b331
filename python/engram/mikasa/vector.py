"""The batch with automatic resets and episode statistics, under the original's name."""

from __future__ import annotations

from typing import Any

import gymnasium as gym

from engram.errors import InvalidArgumentError
from engram.mikasa._torch import torch
from engram.mikasa.gym_utils import find_max_episode_steps_value

__all__ = ["ManiSkillVectorEnv"]


class ManiSkillVectorEnv(gym.vector.VectorEnv):  # type: ignore[type-arg, unused-ignore]
    """Resets environments whose episodes have ended, within the step that ends them.

    Every step's info has "episode" if metrics are recorded. A step that ends episodes returns the
    first observations of the new ones; its info is that of the ended step, with final_info,
    final_observation and the masks _final_info, _final_observation, _elapsed_steps.

    Args:
        env: An environment, wrapped or not, or an id.
        num_envs: For an id; an environment has its own.
        auto_reset: True: ended episodes are followed by new ones.
        ignore_terminations: True: episodes end at the time limit only.
        record_metrics: True: infos have "episode".
        **kwargs: Keywords of gym.make, with an id.
    """

    def __init__(
        self,
        env: Any,
        num_envs: int | None = None,
        auto_reset: bool = True,
        ignore_terminations: bool = False,
        record_metrics: bool = False,
        **kwargs: Any,
    ) -> None:
        if isinstance(env, str):
            env = gym.make(env, num_envs=num_envs or 1, **kwargs)
        elif kwargs:
            raise InvalidArgumentError(
                f"{', '.join(kwargs)}: given with an environment; only an id takes keywords"
            )
        self._env = env
        self.auto_reset = auto_reset
        self.ignore_terminations = ignore_terminations
        self.record_metrics = record_metrics
        self.num_envs = self.base_env.num_envs
        self.spec = env.spec
        self.render_mode = env.render_mode
        self.metadata = getattr(env, "metadata", {})
        self.closed = False
        self.is_vector_env = True
        self.max_episode_steps = find_max_episode_steps_value(env)
        self.success_once = torch.zeros(self.num_envs, dtype=torch.bool)
        self.returns = torch.zeros(self.num_envs)

    # --- what it is ---

    @property
    def base_env(self) -> Any:
        """The environment without wrappers."""
        return self._env.unwrapped

    @property
    def unwrapped(self) -> Any:
        """Alias of ``base_env``."""
        return self.base_env

    @property
    def device(self) -> Any:
        """Device of tensors: the CPU."""
        return self.base_env.device

    @property
    def single_observation_space(self) -> Any:  # type: ignore[override]
        """Space of one environment's observation."""
        return self.base_env.single_observation_space

    @property
    def observation_space(self) -> Any:  # type: ignore[override]
        """Space of the batch's observation."""
        return self.base_env.observation_space

    @property
    def single_action_space(self) -> Any:  # type: ignore[override]
        """Space of one environment's action."""
        return self.base_env.single_action_space

    @property
    def action_space(self) -> Any:  # type: ignore[override]
        """Space of the batch's action."""
        return self.base_env._env.action_space

    # --- running ---

    def reset(
        self, *, seed: Any = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Starts new episodes; options={"env_idx": indices}: of these environments only."""
        observation, info = self._env.reset(seed=seed, options=options)
        indices = (options or {}).get("env_idx")
        chosen: Any = slice(None) if indices is None else torch.as_tensor(indices)
        self.success_once[chosen] = False
        self.returns[chosen] = 0
        return observation, info

    def step(
        self, actions: Any
    ) -> tuple[Any, torch.Tensor, torch.Tensor, torch.Tensor, dict[str, Any]]:
        """One control step of all environments."""
        observation, reward, terminated, truncated, info = self._env.step(actions)
        if self.record_metrics:
            info["episode"] = self._metrics(reward, info)
        if self.ignore_terminations:
            terminated = torch.zeros_like(terminated)
        ended = terminated | truncated
        if self.auto_reset and bool(ended.any()):
            final = {key: dict(v) if isinstance(v, dict) else v for key, v in info.items()}
            info.update(
                final_info=final,
                final_observation=observation,
                _final_info=ended,
                _final_observation=ended,
                _elapsed_steps=ended,
            )
            indices = ended.nonzero().flatten()
            observation, _ = self.reset(options={"env_idx": indices})
        return observation, reward, terminated, truncated, info

    def _metrics(self, reward: torch.Tensor, info: dict[str, Any]) -> dict[str, torch.Tensor]:
        """Metrics of the episodes so far."""
        self.returns = self.returns + reward
        self.success_once = self.success_once | info["success"]
        steps = info["elapsed_steps"]
        metrics = {
            "success_once": self.success_once,
            "return": self.returns.clone(),
            "episode_len": steps,
            "reward": self.returns / steps.clamp_min(1),
        }
        self.success_once = self.success_once.clone()  # resets change it in place
        if self.ignore_terminations:
            metrics["success_at_end"] = info["success"].clone()
        return metrics

    def render(self) -> Any:
        """Images of the environment itself, without what wrappers draw."""
        return self.base_env.render()

    def call(self, name: str, *args: Any, **kwargs: Any) -> Any:
        """A method of the environment, or an attribute."""
        value = getattr(self._env, name)
        return value(*args, **kwargs) if callable(value) else value

    def get_attr(self, name: str) -> Any:
        """An attribute of the environment."""
        return getattr(self._env, name)

    def close(self, **kwargs: Any) -> None:
        """Ends the environment."""
        if not self.closed:
            self.closed = True
            self._env.close()

    def __repr__(self) -> str:
        return f"ManiSkillVectorEnv({self._env})"
