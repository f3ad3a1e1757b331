"""The classes of both halves: the original's module of the first release, where it has one."""

from __future__ import annotations

from engram.mikasa.memory_envs import *  # noqa: F403
from engram.mikasa.memory_envs import __all__ as _vla
from engram.mikasa.rl.memory_envs import *  # noqa: F403
from engram.mikasa.rl.memory_envs import __all__ as _rl

__all__ = list(dict.fromkeys([*_vla, *_rl]))
