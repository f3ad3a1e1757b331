"""Registration with Gymnasium, as "engram/<id>"."""

from __future__ import annotations

import functools
import os
from collections.abc import Mapping
from typing import Any

from engram import _core
from engram._args import values
from engram._args.keywords import check_batch, check_single
from engram._ids import NAMESPACE
from engram.errors import InvalidArgumentError
from engram.tasks import list_tasks

# Entry points are strings "engram.gym_registration:<prefix><id>", which __getattr__ resolves: they
# can be pickled and written as JSON, and need no keyword argument for the id, which Gymnasium 0.29
# would not pass.
_ENV = "make."
_VECTOR_ENV = "make_vec."


# Control steps, for gymnasium.make, whose TimeLimit truncates episodes.
_NO_LIMIT = 1_000_000


def register(
    id: str | None = None,
    *,
    base: str | None = None,
    constants: Mapping[str, Any] | None = None,
    instruction: str | None = None,
) -> None:
    """Registers a new id for a task with other constants, here and with Gymnasium.

    For example::

        engram.register(
            "RememberColor7-Slow-v0",
            base="RememberColor9-VLA-v0",
            constants={"COLORS": 7, "CUE_PHASE_STEPS": (30, 50), "max_episode_steps": 150},
        )

    The same variant twice is one. Without arguments: registers all tasks with Gymnasium, which
    importing engram does already, and Gymnasium 0.29 as well.

    Args:
        id: The new id, a name that ends in -v and a number.
        base: Task, such as "RememberColor9-VLA-v0", or a variant.
        constants: Constants that differ; see ``describe(base)["changeable"]``.
        instruction: In English; None: that of the base.

    Raises:
        UnknownIdError: No such base or constant; the message names the nearest one.
        InvalidArgumentError: The id is taken or the task cannot be made so.
    """
    if id is not None:
        if base is None:
            raise InvalidArgumentError(f"base: None given, the task that '{id}' changes needed")
        _core.register_variant(
            values.text("id", id),
            values.text("base", base),
            values.constants_json({} if constants is None else constants),
            None if instruction is None else values.text("instruction", instruction),
        )
    elif not (base is None and constants is None and instruction is None):
        raise InvalidArgumentError("id: None given, a new id needed")
    _register_all()


def load_variants(path: str | os.PathLike[str]) -> None:
    """Registers all variants of a file (docs/variants.md), or none if one of them is refused."""
    _core.load_variants(values.path("path", path))
    _register_all()


def _register_all() -> None:
    # Imported here: Gymnasium calls this function while it is itself being imported.
    from gymnasium.envs import registration

    for task in list_tasks():
        name = NAMESPACE + task["id"]
        if name in registration.registry:
            continue
        registration.register(
            id=name,
            entry_point=f"engram.gym_registration:{_ENV}{task['id']}",
            vector_entry_point=f"engram.gym_registration:{_VECTOR_ENV}{task['id']}",
            max_episode_steps=task["horizon"],
        )


def __getattr__(name: str) -> Any:
    from engram.envs.env import METADATA

    for prefix, maker in ((_ENV, _make_env), (_VECTOR_ENV, _make_vec)):
        if name.startswith(prefix):
            creator: Any = functools.partial(maker, name[len(prefix) :])
            creator.metadata = METADATA  # gymnasium.make reads the render modes here
            return creator
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def _make_env(id: str, **options: Any) -> Any:
    """An environment for gymnasium.make, which truncates episodes itself."""
    from engram.envs.env import Env

    check_single("gymnasium.make", options)
    if "max_episode_steps" in (options.get("constants") or {}):
        raise InvalidArgumentError(
            "constants: max_episode_steps given; give it to gymnasium.make itself, whose limit "
            "would end episodes earlier otherwise"
        )
    return Env(id, max_episode_steps=_NO_LIMIT, **options)


def _make_vec(id: str, num_envs: int = 1, **options: Any) -> Any:
    """A batch for gymnasium.make_vec."""
    from engram.envs.vector_env import VectorEnv

    check_batch("gymnasium.make_vec", options)
    return VectorEnv(id, num_envs, **options)
