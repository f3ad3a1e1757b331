"""The environment type "engram" of LeRobot's command line."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from lerobot.configs import FeatureType, PolicyFeature
from lerobot.envs import EnvConfig

from engram.datasets.spaces import ANGLES, CONTROL_MODE, Spaces
from engram.integrations.lerobot.vector_env import CAMERAS, LeRobotEnv

_IMAGES = [f"observation.images.{camera}" for camera in CAMERAS]


# Recordings name images as policies do, all else as observations do.
def _features_map() -> dict[str, str]:
    names = {"action": "action", "agent_pos": "observation.state"}
    return {**names, **{name: name for name in _IMAGES}}


@EnvConfig.register_subclass("engram")
@dataclass
class EngramEnvConfig(EnvConfig):  # type: ignore[misc]
    """Tasks and their observations.

    Attributes:
        task: An id, or several with commas between them.
        fps: Control steps per second, for videos and recordings.
        image_size: Side of the images in pixels.
        threads: Threads of a batch; 0: one per core.
        control_mode: Meaning of actions.
        joint_proprio: The state has joint angles instead of the TCP's pose.
        angles: Of the TCP in the state: "continuous", as in data sets of
            `python -m engram.datasets lerobot`, or as the "benchmark" has them.
    """

    task: str | None = "RememberColor3-VLA-v0"
    fps: int = 20
    image_size: int = 128
    threads: int = 0
    control_mode: str = CONTROL_MODE
    joint_proprio: bool = False
    angles: str = ANGLES[0]
    features_map: dict[str, str] = field(default_factory=_features_map)

    def __post_init__(self) -> None:
        """Declares the features of observations and actions."""
        image = PolicyFeature(type=FeatureType.VISUAL, shape=(self.image_size, self.image_size, 3))
        spaces = Spaces(self.control_mode, self.joint_proprio)
        action, proprio = len(spaces.action_names), len(spaces.proprio_names)
        self.features = {
            "action": PolicyFeature(type=FeatureType.ACTION, shape=(action,)),
            "agent_pos": PolicyFeature(type=FeatureType.STATE, shape=(proprio,)),
            **dict.fromkeys(_IMAGES, image),
        }

    @property
    def gym_kwargs(self) -> dict[str, Any]:
        """Unused: batches are made here."""
        return {}

    def create_envs(
        self, n_envs: int, use_async_envs: bool = False
    ) -> dict[str, dict[int, LeRobotEnv]]:
        """{id: {0: batch}}. Batches work on all cores with or without ``use_async_envs``."""
        ids = [id.strip() for id in (self.task or "").split(",")]
        options: dict[str, Any] = {
            "image_size": self.image_size,
            "threads": self.threads,
            "control_mode": self.control_mode,
            "joint_proprio": self.joint_proprio,
            "angles": self.angles,
        }
        return {id: {0: LeRobotEnv(id, n_envs, **options)} for id in ids}
