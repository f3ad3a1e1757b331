"""engram: batched memory-manipulation tasks on CPUs, as Gymnasium environments.

    import engram

    env = engram.make_vec("RememberColor9-VLA-v0", num_envs=256, seed=7)
    obs, info = env.reset()
    for _ in range(60):
        obs, reward, terminated, truncated, info = env.step(env.act("oracle"))

``VectorEnv`` says what a batch offers, ``list`` and ``describe`` which tasks there are.
"""

from __future__ import annotations

from typing import Any

from engram import _core
from engram._compat import AutoresetMode
from engram.env import Env
from engram.errors import (
    BadStateError,
    Error,
    InternalError,
    InvalidArgumentError,
    IoError,
    UnavailableError,
    UnknownIdError,
)
from engram.evaluation import evaluate
from engram.registration import register
from engram.registry import describe
from engram.registry import list_tasks as list
from engram.vector_env import VectorEnv

__all__ = [
    "AutoresetMode",
    "BadStateError",
    "Env",
    "Error",
    "InternalError",
    "InvalidArgumentError",
    "IoError",
    "UnavailableError",
    "UnknownIdError",
    "VectorEnv",
    "describe",
    "evaluate",
    "list",
    "make",
    "make_vec",
    "register",
]

__version__: str = _core.version()


def make(id: str, **options: Any) -> Env:
    """One environment; see ``Env``."""
    return Env(id, **options)


def make_vec(id: str, num_envs: int = 1, **options: Any) -> VectorEnv:
    """A batch of environments; see ``VectorEnv``."""
    return VectorEnv(id, num_envs, **options)


register()
