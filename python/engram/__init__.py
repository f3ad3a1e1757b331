"""engram: batched memory-manipulation tasks on CPUs, as Gymnasium environments.

    import engram

    env = engram.make_vec("RememberColor9-VLA-v0", num_envs=256, seed=7, autoreset_mode="DISABLED")
    obs, info = env.reset()
    for _ in range(env.description["horizon"]):
        obs, reward, terminated, truncated, info = env.step(env.act("oracle"))

``VectorEnv`` documents a batch, ``list`` and ``describe`` return the tasks.
"""

from __future__ import annotations

import builtins
import importlib
import os
from typing import TYPE_CHECKING, Any

from engram import _interpreter  # noqa: F401 (before all others)

# isort: split
from engram import _core, _distribution
from engram._args.values import worker_seed
from engram.errors import (
    BadStateError,
    Error,
    InternalError,
    InvalidArgumentError,
    IoError,
    TaskFailedError,
    UnavailableError,
    UnknownIdError,
)
from engram.evaluation import compare, evaluate, merge, probe, report, suites
from engram.factory import make, make_vec
from engram.gym_registration import load_variants, register
from engram.tasks import describe
from engram.tasks import list_tasks as list

if TYPE_CHECKING:
    from engram import kit
    from engram.envs.compat import AutoresetMode
    from engram.envs.env import Env
    from engram.envs.vector_env import VectorEnv
    from engram.kit.files import load_tasks
    from engram.kit.registration import register_task
    from engram.kit.task import Task

__all__ = [
    "AutoresetMode",
    "BadStateError",
    "Env",
    "Error",
    "InternalError",
    "InvalidArgumentError",
    "IoError",
    "Task",
    "TaskFailedError",
    "UnavailableError",
    "UnknownIdError",
    "VectorEnv",
    "compare",
    "describe",
    "evaluate",
    "kit",
    "list",
    "load_tasks",
    "load_variants",
    "make",
    "make_vec",
    "merge",
    "probe",
    "register",
    "register_task",
    "report",
    "suites",
    "worker_seed",
]

__version__: str = _core.version()

_distribution.warn_of_other_distribution(stacklevel=2)

# Names that are loaded on first use, and their modules: those that need Gymnasium, because it
# imports this package, to register its tasks, while it is itself being imported; and what only
# tasks of users need.
_LAZY = {
    "AutoresetMode": "envs.compat",
    "Env": "envs.env",
    "Task": "kit.task",
    "VectorEnv": "envs.vector_env",
    "load_tasks": "kit.files",
    "register_task": "kit.registration",
}
_LAZY_MODULES = ("kit", "wrappers")


def __getattr__(name: str) -> Any:
    if name in _LAZY_MODULES:
        return importlib.import_module(f"{__name__}.{name}")
    if name not in _LAZY:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(f"{__name__}.{_LAZY[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> builtins.list[str]:
    return sorted({*globals(), *_LAZY, *_LAZY_MODULES})


if ".py" in os.environ.get("ENGRAM_TASKS", ""):
    importlib.import_module(f"{__name__}.kit.files").load_environment()
register()
