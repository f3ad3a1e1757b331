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
        act: Takes observations (N, D), or a dict of arrays where there are pictures, and a mask
            (N,), True where an episode begins; returns actions (N, A). Rows of environments that
            need no action are those of an earlier step.
    """

    def __init__(self, env: Any, act: Act) -> None:
        self._act = act
        self._wrappers: list[Wrapper] = []
        while isinstance(env, Wrapper):
            self._wrappers.insert(0, env)
            env = env.env
        space = env.observation_space
        # Observations by their names in an evaluation; rows alone have none in a batch.
        self._seen = {
            name: np.zeros(part.shape, part.dtype)
            for name, part in getattr(space, "spaces", {"state": space}).items()
        }
        self._rows_alone = not hasattr(space, "spaces")
        self._elapsed = np.zeros(env.num_envs, np.int64)

    def __call__(self, observation: Mapping[str, Any]) -> np.ndarray:
        """Actions of the episodes that need one."""
        slots = np.asarray(observation["slot"], np.int64)
        if np.any(observation["worker"]) or slots.max() >= len(self._elapsed):
            raise InvalidArgumentError(
                f"evaluation: of other environments than the policy's {len(self._elapsed)}; "
                f"num_envs={len(self._elapsed)} and threads=1 needed"
            )
        began = np.zeros(len(self._elapsed), np.bool_)
        began[slots] = np.asarray(observation["first"], np.bool_)
        for name, part in self._seen.items():
            if observation.get(name) is None:
                raise InvalidArgumentError(
                    f"evaluation: has no {name!r}, which the policy's environment has"
                )
            part[slots] = observation[name]
        self._elapsed[slots] = observation["step"]
        rows: Any = self._seen["state"] if self._rows_alone else self._seen
        for wrapper in self._wrappers:
            wrapper.begin(began)
            rows = wrapper.observation(rows, {"elapsed_steps": self._elapsed}, began)
        actions = np.asarray(self._act(rows, began), np.float32)
        for wrapper in reversed(self._wrappers):
            actions = wrapper.action(actions)
        return actions[slots]
