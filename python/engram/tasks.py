"""The registered tasks and their descriptions."""

from __future__ import annotations

import builtins
import json
from typing import TYPE_CHECKING, Any

from engram import _core
from engram._args.keywords import check_batch

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from engram.typing import BatchOptions, ObsMode, TaskDescription, TaskSummary


def list_tasks() -> builtins.list[TaskSummary]:
    """All registered tasks: the benchmark's, in its order, then variants.

    Each is a dict: id, family, split ("short", "medium", "long", "extended", "rl"), memory_type,
    horizon (control steps), canonical, instruction, action_dim, state_dim, candidates (how many
    answers a guess chooses from).
    """
    tasks: builtins.list[TaskSummary] = json.loads(_core.list_json())
    return tasks


def describe(
    id: str, *, obs_mode: ObsMode = "state", **options: Unpack[BatchOptions]
) -> TaskDescription:
    """One task in full: what ``engram info ID --json`` prints.

    Args:
        id: Task, such as "RememberColor9-VLA-v0".
        obs_mode: See ``VectorEnv``; state_fields depend on it.
        **options: Those of ``VectorEnv`` that the description depends on, such as control_mode.

    Returns:
        A dict with, among others, action_spaces, draws (what pins may name), options
        (task_options), phases, state_fields (name, offset, width, unit; with obs_mode="objects"
        also low, high and, of one-hot parts, names), outputs, reward_terms, constants,
        changeable (constants that can be changed, with bounds), changed, warnings (of constants
        that have no effect under these rules).
        ``engram.typing.TaskDescription`` has all of them.

    Raises:
        UnknownIdError: No task of that id; the message names the nearest one.
    """
    from engram.envs.vector_env import VectorEnv

    check_batch("describe", options)
    given: Any = {"threads": 1, **options}
    env = VectorEnv(id, num_envs=1, obs_mode=obs_mode, **given)
    try:
        return env.description
    finally:
        env.close()
