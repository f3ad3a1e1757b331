"""Episodes of the oracle: what a policy sees in each step, and what the oracle does there."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import numpy.typing as npt

from engram.factory import make
from engram.servers.conventions import state_of

Array = npt.NDArray[Any]

_LONGEST = 300  # steps, of which the images take up 30 MB


@dataclasses.dataclass(frozen=True)
class Recording:
    """An episode; rgb, proprio and actions have the time first."""

    env_id: str
    seed: int
    instruction: str
    rgb: Array
    proprio: Array
    actions: Array

    def __len__(self) -> int:
        return len(self.actions)

    def observation(self, step: int, *, first: bool, tell: bool) -> dict[str, Any]:
        """A step as an observation of engram.evaluate, of one episode."""
        seen: dict[str, Any] = {
            "env_id": self.env_id,
            "worker": 0,
            "slot": np.zeros(1, np.int32),
            "episode": np.zeros(1, np.int32),
            "step": np.full(1, step, np.int32),
            "first": np.full(1, first, np.uint8),
            "instruction": [self.instruction],
            "proprio": self.proprio[step : step + 1],
            "rgb": self.rgb[step : step + 1],
            "state": None,
        }
        if tell:
            seen["seed"] = np.full(1, self.seed, np.uint64)
        return seen


def record(env_id: str, seed: int, **options: Any) -> Recording:
    """Plays an episode by the oracle; options: those of the environment."""
    env: Any = make(env_id, obs_mode="rgb", **options)
    seen, _ = env.reset(seed=seed)
    instruction = env.unwrapped.language_instruction
    rgb: list[Array] = []
    proprio: list[Array] = []
    actions: list[Array] = []
    ended = False
    while not ended and len(actions) < _LONGEST:
        action = np.array(env.act("oracle"), np.float32)
        rgb.append(seen["rgb"])
        proprio.append(seen["proprio"])
        actions.append(action)
        seen, _, terminated, truncated, _ = env.step(action)
        ended = terminated or truncated
    env.close()
    return Recording(env_id, seed, instruction, *map(np.stack, (rgb, proprio, actions)))


def states_of(layout: str, proprio: Array) -> Array:
    """The states of an episode, (T, W), each following from the one before."""
    states: list[Array] = []
    for row in proprio:
        states.append(state_of(layout, row, states[-1] if states else None))
    return np.stack(states)
