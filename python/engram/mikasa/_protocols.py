"""Parts of an environment that its robot and its attributes read."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar, Protocol

import numpy as np

from engram.mikasa._torch import torch

if TYPE_CHECKING:
    from engram.envs.vector_env import VectorEnv
    from engram.mikasa._keywords import Settings
    from engram.typing import TaskDescription


class RobotSource(Protocol):
    """Parts that the robot reads."""

    num_envs: int
    control_mode: Any
    task_id: str

    def _robot_part(self, name: str) -> torch.Tensor: ...
    def _view(self, name: str) -> np.ndarray | None: ...


class CameraSource(Protocol):
    """Parts that cameras read."""

    num_envs: int
    _chosen: Settings
    _env: VectorEnv[Any]


class StateSource(Protocol):
    """Parts that attributes are computed from; constants of the task are attributes too."""

    obs_mode: str
    _family: ClassVar[str]
    _env: VectorEnv[Any]
    _description: TaskDescription

    def _view(self, name: str) -> np.ndarray | None: ...
    def __getattr__(self, name: str) -> Any: ...
