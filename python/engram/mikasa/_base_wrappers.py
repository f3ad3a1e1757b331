"""Wrappers that forward attributes, as Gymnasium 0.29's do and 1.x's do not."""

from __future__ import annotations

from contextlib import nullcontext
from typing import Any

import gymnasium as gym

from engram.mikasa._observing import Observations, Wanted


class Wrapper(gym.Wrapper[Any, Any, Any, Any]):
    """Wrapper that forwards unknown attributes to the wrapped environment."""

    # True if Wanted.POLICY suffices.
    _passes_parts = False

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name == "env":
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        return getattr(self.env, name)

    @property
    def spec(self) -> Any:  # type: ignore[override]
        """Specification of the wrapped environment."""
        return self.env.spec


def source(env: Any, part: Wanted) -> Observations | None:
    """Source of the observations of a wrapper around ``env``, if this part suffices.

    None if a wrapper or a class of the user's in between may need the rest.
    """
    while env is not env.unwrapped:
        kind = type(env)
        own = kind.__module__.startswith("engram.mikasa.")
        if not own or (part is Wanted.POLICY and not kind._passes_parts):
            return None
        env = env.env
    made: Observations = env._observations
    return made if "_generated" in vars(type(env)) else None


class ObservationWrapper(Wrapper, gym.ObservationWrapper[Any, Any, Any]):
    """Changes observations."""

    # Source that can make just the part that this wrapper needs, or None.
    _source: Observations | None = None
    _needs = Wanted.ALL

    def reset(self, **kwargs: Any) -> tuple[Any, dict[str, Any]]:
        """See the wrapped environment."""
        with self._only_needed():
            observation, info = self.env.reset(**kwargs)
            return self.observation(observation), info

    def step(self, action: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """See the wrapped environment."""
        with self._only_needed():
            observation, reward, terminated, truncated, info = self.env.step(action)
            return self.observation(observation), reward, terminated, truncated, info

    def _only_needed(self) -> Any:
        """Context in which only the needed part of observations is made."""
        return nullcontext() if self._source is None else self._source.only(self._needs)

    def _update_space(self, observation: Any) -> None:
        """Takes the spaces, here and of the environment itself, from an observation."""
        base: Any = self.unwrapped
        base.update_obs_space(observation)


class ActionWrapper(Wrapper, gym.ActionWrapper[Any, Any, Any]):
    """Changes actions, and counts the steps of episodes."""

    _passes_parts = True

    def __init__(self, env: gym.Env[Any, Any]) -> None:
        super().__init__(env)
        self.current_steps: Any = None

    def step(self, action: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """See the wrapped environment."""
        result = self.env.step(self.action(action))
        self.current_steps = result[4]["elapsed_steps"]
        return result

    def reset(self, **kwargs: Any) -> tuple[Any, dict[str, Any]]:
        """See the wrapped environment."""
        observation, info = self.env.reset(**kwargs)
        self.current_steps = info["elapsed_steps"]
        return observation, info
