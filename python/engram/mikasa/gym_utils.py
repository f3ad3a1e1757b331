"""Lengths of episodes."""

from __future__ import annotations

from typing import Any

__all__ = ["find_max_episode_steps_value"]


def find_max_episode_steps_value(env: Any) -> int | None:
    """The limit of the outermost wrapper that has one; None without."""
    while env is not None:
        for name in ("max_episode_steps", "_max_episode_steps"):
            steps = env.__dict__.get(name)
            if steps is not None:
                return int(steps)
        env = env.__dict__.get(
            "env", env.__dict__.get("_env") if "returns" in env.__dict__ else None
        )
    return None
