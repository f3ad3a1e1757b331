"""The tasks and what can be known of them before they run."""

from __future__ import annotations

import builtins
import json
from typing import Any

from engram import _core

NAMESPACE = "engram/"  # of ids in Gymnasium's registry


def list_tasks() -> builtins.list[dict[str, Any]]:
    """All registered tasks: the benchmark's, in its order, then variants.

    Each is a dict: id, family, split ("short", "medium", "long", "extended"), memory_type, horizon
    (control steps), canonical, instruction, action_dim, state_dim, candidates (how many answers a
    guess chooses from).
    """
    return json.loads(_core.list_json())


def describe(id: str, **options: Any) -> dict[str, Any]:
    """One task in full: what ``engram info ID --json`` prints.

    Args:
        id: Task, such as "RememberColor9-VLA-v0".
        **options: Those of ``VectorEnv`` that the description depends on, such as control_mode.

    Returns:
        A dict: among others action_spaces, draws (what pins may name), options (task_options),
        phases, state_fields (name, offset, width, unit; with obs_mode="objects" also low, high
        and, of one-hot parts, names), outputs, reward_terms, constants,
        changeable (constants that can be changed, with bounds), changed.

    Raises:
        UnknownIdError: No task of that id; the message names the nearest one.
    """
    from engram.vector_env import VectorEnv

    env = VectorEnv(id, num_envs=1, threads=1, **options)
    try:
        return env.description
    finally:
        env.close()
