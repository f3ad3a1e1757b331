"""The original's interface, for scripts that were written for MIKASA-Robo-VLA.

    import engram.mikasa  # was: mikasa_robo_suite.vla.memory_envs
    from engram.mikasa import apply_mikasa_vla_wrappers

    env = gym.make("RememberColor3-VLA-v0", num_envs=1, obs_mode="rgb",
                   control_mode="pd_ee_delta_pose")
    env = apply_mikasa_vla_wrappers(env)

Importing it registers the benchmark's ids with Gymnasium, without a namespace. docs/mikasa.md says
what is served, ignored and refused, and what is otherwise than in the original.
"""

from __future__ import annotations

from engram.mikasa.classes import *
from engram.mikasa.env import BaseEnv
from engram.mikasa.registration import register_env
