"""The cameras of an environment, under the names that the original's scene has for them."""

from __future__ import annotations

from typing import Any

from engram.envs.queries import CAMERA_MATRICES
from engram.mikasa._observing import tensor
from engram.mikasa._protocols import CameraSource
from engram.mikasa._torch import torch


class Sensor:
    """A camera that observations with images have.

    Attributes:
        uid: Its name.
        width, height: Of its images.
    """

    def __init__(self, env: CameraSource, uid: str) -> None:
        self._env = env
        self.uid = uid
        self.width, self.height = env._chosen.image_size

    def get_params(self) -> dict[str, torch.Tensor]:
        """Its present matrices: extrinsic_cv (B, 3, 4), cam2world_gl (B, 4, 4), intrinsic_cv."""
        values = self._env._env._batch.camera_params(self.uid, self.width, self.height)
        return {name: tensor(value) for name, value in zip(CAMERA_MATRICES, values)}

    def __repr__(self) -> str:
        return f"Sensor({self.uid!r}, {self.width}, {self.height})"


class Scene:
    """The scene of an environment, of which only the cameras can be reached.

    Attributes:
        sensors: Cameras by name, in the order of channels.
    """

    def __init__(self, env: CameraSource) -> None:
        self.num_envs = env.num_envs
        self.sensors = {uid: Sensor(env, uid) for uid in env._chosen.cameras}

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(
            f"scene.{name}: engram has no bodies to move; of the scene it has sensors and num_envs"
        )
