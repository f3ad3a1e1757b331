"""Wrappers that hand on attributes, as Gymnasium 0.29's do and 1.x's do not."""

from __future__ import annotations

from contextlib import nullcontext
from typing import Any

import gymnasium as gym

from engram.mikasa._observing import Observations, Wanted


class Wrapper(gym.Wrapper[Any, Any, Any, Any]):
    """Asked for what it has not, it asks the environment within."""

    # Whether Wanted.POLICY is enough for it.
    _passes_parts = False

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name == "env":
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        return getattr(self.env, name)

    @property
    def spec(self) -> Any:  # type: ignore[override]
        """That of the environment within."""
        return self.env.spec


def source(env: Any, part: Wanted) -> Observations | None:
    """What makes the observations that reach a wrapper around ``env``, if it may make this part.

    None if somebody on the way, a wrapper of the user's or a class of theirs, could miss the rest.
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

    # What makes them, if it can make at once the part that this wrapper needs.
    _source: Observations | None = None
    _needs = Wanted.ALL

    def reset(self, **kwargs: Any) -> tuple[Any, dict[str, Any]]:
        """As of the environment within."""
        with self._asked():
            observation, info = self.env.reset(**kwargs)
            return self.observation(observation), info

    def step(self, action: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """As of the environment within."""
        with self._asked():
            observation, reward, terminated, truncated, info = self.env.step(action)
            return self.observation(observation), reward, terminated, truncated, info

    def _asked(self) -> Any:
        """While it lasts, what would be thrown away is not made."""
        return nullcontext() if self._source is None else self._source.only(self._needs)

    def _update_space(self, observation: Any) -> None:
        """Takes the spaces, here and of the environment itself, from an observation."""
        base: Any = self.unwrapped
        base.update_obs_space(observation)


class ActionWrapper(Wrapper, gym.ActionWrapper[Any, Any, Any]):
    """Changes actions; knows how many steps episodes have had."""

    _passes_parts = True

    def __init__(self, env: gym.Env[Any, Any]) -> None:
        super().__init__(env)
        self.current_steps: Any = None

    def step(self, action: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """As of the environment within."""
        result = self.env.step(self.action(action))
        self.current_steps = result[4]["elapsed_steps"]
        return result

    def reset(self, **kwargs: Any) -> tuple[Any, dict[str, Any]]:
        """As of the environment within."""
        observation, info = self.env.reset(**kwargs)
        self.current_steps = info["elapsed_steps"]
        return observation, info
