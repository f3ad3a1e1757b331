"""Specification of an episode: task, seed, and what is not as usual."""

from __future__ import annotations

import dataclasses
import json
import secrets
from collections.abc import Mapping
from typing import Any

import engram

_RANDOM_SEEDS = 2**31  # short enough for people


@dataclasses.dataclass(frozen=True)
class EpisodeSpec:
    """Choices for an episode.

    Rules come from a folder that is watched, perturbations and physics from there or from the
    command line.
    """

    id: str
    seed: int
    seed_given: bool = True
    pins: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    constants: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    options: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    rules: str = "reference"
    physics: str = "engram"
    perturb: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    choices: bool = False  # the player names answers, and a scripted hand acts

    @classmethod
    def from_message(cls, message: Mapping[str, Any]) -> EpisodeSpec:
        """Makes it from a checked message; the seed is random if there is none."""
        given = message.get("seed") is not None
        return cls(
            message["id"],
            int(message["seed"]) if given else secrets.randbelow(_RANDOM_SEEDS),
            given,
            message.get("pins", {}),
            message.get("constants", {}),
            message.get("options", {}),
            choices=message.get("choices", False),
        )

    @property
    def is_default(self) -> bool:
        """Without changes: seed and actions reproduce the episode, and rates of the task apply."""
        changed = self.pins or self.constants or self.options or self.perturb
        return not changed and self.physics == "engram"

    @property
    def batch_key(self) -> str:
        """Equal for episodes that the same batch can play."""
        changes = [dict(self.constants), dict(self.options), dict(self.perturb), self.physics]
        return json.dumps([self.id, *changes], sort_keys=True)

    def make_batch(self, num_envs: int = 1, **more: Any) -> engram.VectorEnv[Any]:
        """A batch for such episodes, not yet reset; ended environments are held."""
        given: Any = {
            "constants": dict(self.constants) or None,
            "task_options": dict(self.options) or None,
            "rules": self.rules,
            "physics": self.physics,
            "perturb": dict(self.perturb) or None,
            "control_mode": "pd_ee_delta_pose",  # keys and sliders move the tool
            "autoreset_mode": "DISABLED",
            "after_end": "hold",
            "threads": 1,
            **more,
        }
        return engram.make_vec(self.id, num_envs, **given)

    def reset(self, env: engram.VectorEnv[Any], seed: int | None = None) -> Any:
        """Begins the episode in all environments of the batch, with consecutive seeds."""
        return env.reset(
            seed=self.seed if seed is None else seed, options={"pins": dict(self.pins)}
        )
