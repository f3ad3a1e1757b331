"""Groups of environments that play the same episodes, each with actions of its own."""

from __future__ import annotations

from typing import Any

import numpy as np

from engram._args.values import integer
from engram.errors import InvalidArgumentError
from engram.wrappers.base import Wrapper


class EqualStarts(Wrapper):
    """Gives ``group_size`` environments in a row the same episodes, as GRPO compares them.

    ::

        env = engram.wrappers.EqualStarts(engram.make_vec(id, 64), group_size=8)
        obs, info = env.reset(seed=0)  # 8 episodes, each in 8 environments

    After a reset the n-th episode of each environment is that of its group, also where automatic
    resets begin it. ``reset(seed=s)`` gives group g the seed s + g. Without a seed the first reset
    begins at the batch's own, and each later one goes on behind the seeds of the one before. Lists
    of seeds, and resets of some environments, are the batch's own.

    Args:
        env: A batch of one task, or a wrapper of one.
        group_size: Divides the number of environments.

    Attributes:
        group: The group of each environment, (N,).
    """

    def __init__(self, env: Any, group_size: int) -> None:
        super().__init__(env)
        size = integer("group_size", group_size, 1, self.num_envs)
        if self.num_envs % size or "tasks" in env.description:
            raise InvalidArgumentError(
                f"group_size: {size} given for {self.num_envs} environments; a divisor of their "
                "number, and environments of one task, needed"
            )
        self.group = np.arange(self.num_envs) // size
        self._next = int(env.unwrapped.seed)

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> Any:
        """Starts new episodes, the same in each group."""
        whole = (options or {}).get("reset_mask") is None
        if np.ndim(seed) == 0 and (seed is not None or whole):
            first = self._next if seed is None else integer("seed", seed, 0, 2**64 - 1)
            groups = int(self.group[-1]) + 1
            self._next = (first + groups) % 2**64
            seed = [(first + int(g)) % 2**64 for g in self.group]
        return super().reset(seed=seed, options=options)
