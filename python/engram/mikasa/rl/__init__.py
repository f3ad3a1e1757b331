"""The RL half of the original: ids without "VLA" in their names, their classes and wrappers.

    import engram.mikasa.rl  # was: mikasa_robo_suite.rl.memory_envs

    env = gym.make("RememberColor3-v0", num_envs=16, obs_mode="state")

Importing engram.mikasa registers these ids, too.
"""

from __future__ import annotations

from engram.mikasa.classes import RL_CLASSES
from engram.mikasa.rl.memory_envs import *  # noqa: F403
from engram.mikasa.rl.wrappers import *  # noqa: F403
from engram.mikasa.rl.wrappers import __all__ as _wrappers

__all__ = [*RL_CLASSES, *_wrappers]
