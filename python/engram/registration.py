"""Entry in Gymnasium's registry, as "engram/<id>"."""

from __future__ import annotations

import functools
from typing import Any

from engram.registry import NAMESPACE, list_tasks

# Entry points are strings "engram.registration:<prefix><id>", which __getattr__ resolves: they can
# be pickled and written as JSON, and need no keyword argument for the id (0.29 would not pass it).
_ENV = "make."
_VECTOR_ENV = "make_vec."


def register() -> None:
    """Registers all tasks; importing engram does it already, and Gymnasium 0.29 as well."""
    # Not from gymnasium, which calls this before it is complete, nor at the top, which would call
    # it before this module is.
    from gymnasium.envs import registration

    for task in list_tasks():
        name = NAMESPACE + task["id"]
        if name in registration.registry:
            continue
        registration.register(
            id=name,
            entry_point=f"engram.registration:{_ENV}{task['id']}",
            vector_entry_point=f"engram.registration:{_VECTOR_ENV}{task['id']}",
            max_episode_steps=task["horizon"],
        )


def __getattr__(name: str) -> Any:
    from engram.env import Env
    from engram.vector_env import VectorEnv

    for prefix, maker in ((_ENV, Env), (_VECTOR_ENV, VectorEnv)):
        if name.startswith(prefix):
            return functools.partial(maker, name[len(prefix) :])
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
