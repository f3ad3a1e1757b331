"""The original's interface, for scripts that were written for MIKASA-Robo-VLA.

    import engram.mikasa  # was: mikasa_robo_suite.vla.memory_envs
    from engram.mikasa import apply_mikasa_vla_wrappers

    env = gym.make("RememberColor3-VLA-v0", num_envs=1, obs_mode="rgb",
                   control_mode="pd_ee_delta_pose")
    env = apply_mikasa_vla_wrappers(env)

Importing it registers the benchmark's ids with Gymnasium, without a namespace. docs/mikasa.md
lists what is supported, ignored and refused, and differences from the original.
"""

from __future__ import annotations

from engram.mikasa import common, gym_utils
from engram.mikasa.agent import Pose
from engram.mikasa.apply_wrappers import (
    EXTENDED_WRAPPER_CONFIGS,
    MIKASA_VLA_ENV_IDS,
    VLA_WRAPPER_CONFIGS,
    VLAWrapperConfig,
    apply_mikasa_vla_wrappers,
)
from engram.mikasa.classes import *  # noqa: F403
from engram.mikasa.classes import CLASSES
from engram.mikasa.common import flatten_state_dict
from engram.mikasa.dataset_naming import env_id_to_dataset_name, is_dataset_name
from engram.mikasa.env import BaseEnv
from engram.mikasa.gym_utils import find_max_episode_steps_value
from engram.mikasa.ppo_memtasks import (
    Agent,
    AgentStateOnly,
    Args,
    DictArray,
    FlattenRGBDObservationWrapper,
    Logger,
    NatureCNN,
    layer_init,
)
from engram.mikasa.record import FlattenActionSpaceWrapper, RecordEpisode
from engram.mikasa.registration import TimeLimitWrapper, register_env
from engram.mikasa.vector import ManiSkillVectorEnv
from engram.mikasa.wrappers import *  # noqa: F403
from engram.mikasa.wrappers import __all__ as _wrappers

__all__ = [
    "EXTENDED_WRAPPER_CONFIGS",
    "MIKASA_VLA_ENV_IDS",
    "VLA_WRAPPER_CONFIGS",
    "Agent",
    "AgentStateOnly",
    "Args",
    "BaseEnv",
    "DictArray",
    "FlattenActionSpaceWrapper",
    "FlattenRGBDObservationWrapper",
    "Logger",
    "ManiSkillVectorEnv",
    "NatureCNN",
    "Pose",
    "RecordEpisode",
    "TimeLimitWrapper",
    "VLAWrapperConfig",
    "apply_mikasa_vla_wrappers",
    "common",
    "env_id_to_dataset_name",
    "find_max_episode_steps_value",
    "flatten_state_dict",
    "gym_utils",
    "is_dataset_name",
    "layer_init",
    "register_env",
    *CLASSES,
    *_wrappers,
]
