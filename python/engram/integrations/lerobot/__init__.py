"""LeRobot integration: importing this module registers the environment type "engram".

    lerobot-eval --env.discover_packages_path=engram.integrations.lerobot --env.type=engram \
        --env.task=RememberColor3-VLA-v0 --policy.path=FOLDER --eval.n_episodes=50

Images and state have the names of the LeRobot data sets that engram's demonstrations are converted
to: observation.images.top, observation.images.wrist, observation.state.
"""

from __future__ import annotations

from engram.integrations.lerobot.configuration import EngramEnvConfig
from engram.integrations.lerobot.policy import LeRobotPolicy
from engram.integrations.lerobot.vector_env import LeRobotEnv, make_env

__all__ = ["EngramEnvConfig", "LeRobotEnv", "LeRobotPolicy", "make_env"]
