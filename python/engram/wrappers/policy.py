"""A policy trained in wrappers, as evaluations take it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from engram.errors import InvalidArgumentError
from engram.wrappers.base import Wrapper

# Actions (N, A) of all environments, from their observations (N, ...) and a mask of those that
# begin an episode.
Act = Callable[[np.ndarray, np.ndarray], Any]


class WrappedPolicy:
    """Gives a policy the observations, and the batch the actions, of an environment's wrappers.

    ::

        env = engram.make_vec(id, 50, preset="train")
        policy = engram.wrappers.WrappedPolicy(env, lambda rows, begins: network(rows))
        engram.evaluate(policy, id, obs="state", num_envs=50, threads=1)

    The environment is not stepped, its wrappers alone are used.

    Args:
        env: A wrapped batch of as many environments as the evaluation has.
        act: Takes observations (N, D) and a mask (N,), True where an episode begins; returns
            actions (N, A). Rows of environments that need no action are those of an earlier step.
    """

    def __init__(self, env: Any, act: Act) -> None:
        self._act = act
        self._wrappers: list[Wrapper] = []
        while isinstance(env, Wrapper):
            self._wrappers.insert(0, env)
            env = env.env
        self._rows = np.zeros(env.observation_space.shape, np.float32)
        self._elapsed = np.zeros(env.num_envs, np.int64)

    def __call__(self, observation: Mapping[str, Any]) -> np.ndarray:
        """Actions of the episodes that need one."""
        slots = np.asarray(observation["slot"], np.int64)
        if np.any(observation["worker"]) or slots.max() >= len(self._rows):
            raise InvalidArgumentError(
                f"evaluation: of other environments than the policy's {len(self._rows)}; "
                f"num_envs={len(self._rows)} and threads=1 needed"
            )
        began = np.zeros(len(self._rows), np.bool_)
        began[slots] = np.asarray(observation["first"], np.bool_)
        self._rows[slots] = observation["state"]
        self._elapsed[slots] = observation["step"]
        rows: Any = self._rows
        for wrapper in self._wrappers:
            wrapper.begin(began)
            rows = wrapper.observation(rows, {"elapsed_steps": self._elapsed}, began)
        actions = np.asarray(self._act(rows, began), np.float32)
        for wrapper in reversed(self._wrappers):
            actions = wrapper.action(actions)
        return actions[slots]
