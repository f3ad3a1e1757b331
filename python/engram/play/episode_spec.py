"""What an episode is made of: task, seed, pins, constants, options of the task, rules."""

from __future__ import annotations

import dataclasses
import json
import secrets
from collections.abc import Mapping
from typing import Any

import engram

_RANDOM_SEEDS = 2**31  # short enough to be read out


@dataclasses.dataclass(frozen=True)
class Setting:
    """All that the page may choose of an episode; rules are those of a folder that is watched."""

    id: str
    seed: int
    seed_given: bool = True
    pins: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    constants: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    options: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    rules: str = "reference"

    @classmethod
    def of(cls, message: Mapping[str, Any]) -> Setting:
        """What a checked message says; without a seed, one that nobody knows."""
        given = message.get("seed") is not None
        return cls(
            message["id"],
            int(message["seed"]) if given else secrets.randbelow(_RANDOM_SEEDS),
            given,
            message.get("pins", {}),
            message.get("constants", {}),
            message.get("options", {}),
        )

    @property
    def plain(self) -> bool:
        """Whether seed and actions alone make the episode again, and rates of the task apply."""
        return not (self.pins or self.constants or self.options)

    @property
    def kind(self) -> str:
        """Settings of the same kind can be played by the same batch."""
        return json.dumps([self.id, dict(self.constants), dict(self.options)], sort_keys=True)

    def batch(self, num_envs: int = 1, **more: Any) -> engram.VectorEnv[Any]:
        """A batch for such episodes, not yet reset; ended environments hold still."""
        given: Any = {
            "constants": dict(self.constants) or None,
            "task_options": dict(self.options) or None,
            "rules": self.rules,
            "autoreset_mode": "DISABLED",
            "after_end": "hold",
            "threads": 1,
            **more,
        }
        return engram.make_vec(self.id, num_envs, **given)

    def reset(self, env: engram.VectorEnv[Any], seed: int | None = None) -> Any:
        """Begins the episode in all environments of the batch, with seeds one after the other."""
        return env.reset(
            seed=self.seed if seed is None else seed, options={"pins": dict(self.pins)}
        )
