"""The robot, read-only: joints, tool, base."""

from __future__ import annotations

from typing import Any

import numpy as np

from engram.errors import UnavailableError
from engram.mikasa._protocols import RobotSource
from engram.mikasa._torch import torch

_BASE_X = -0.615  # m
_ARM_JOINTS = 7


class Pose:
    """Poses of a batch.

    Attributes:
        raw_pose: (B, 7): p, then q.
    """

    def __init__(self, raw_pose: torch.Tensor) -> None:
        self.raw_pose = raw_pose

    @property
    def p(self) -> torch.Tensor:
        """Positions in the world, (B, 3), m."""
        return self.raw_pose[..., :3]

    @property
    def q(self) -> torch.Tensor:
        """Quaternions w, x, y, z, (B, 4)."""
        return self.raw_pose[..., 3:]

    def __len__(self) -> int:
        return len(self.raw_pose)

    def __repr__(self) -> str:
        return f"Pose({self.raw_pose})"


class Link:
    """A part of the robot."""

    def __init__(self, env: RobotSource, name: str) -> None:
        self._env = env
        self.name = name

    @property
    def pose(self) -> Pose:
        """Present pose."""
        return Pose(self._env._robot_part("tcp_pose"))


class Robot:
    """The arm and its base."""

    name = "panda"

    def __init__(self, env: RobotSource) -> None:
        self._env = env

    def get_qpos(self) -> torch.Tensor:
        """Joint positions (B, 9): seven of the arm, rad, two fingers, m."""
        return self._env._robot_part("qpos")

    def get_qvel(self) -> torch.Tensor:
        """Joint velocities (B, 9)."""
        return self._env._robot_part("qvel")

    qpos = property(get_qpos)
    qvel = property(get_qvel)

    @property
    def pose(self) -> Pose:
        """Pose of the base."""
        raw = torch.zeros(self._env.num_envs, 7)
        raw[:, 0] = _BASE_X
        raw[:, 3] = 1
        return Pose(raw)


class Agent:
    """The robot as tasks and planners use it."""

    uid: str

    def __init__(self, env: RobotSource) -> None:
        self._env = env
        self.robot = Robot(env)
        self.tcp = Link(env, "panda_hand_tcp")

    @property
    def tcp_pose(self) -> Pose:
        """Pose of the point between the finger tips."""
        return self.tcp.pose

    @property
    def tcp_pos(self) -> torch.Tensor:
        """Its position."""
        return self.tcp.pose.p

    @property
    def control_mode(self) -> str:
        """Control mode of the environment."""
        return self._env.control_mode

    def is_static(self, threshold: float = 0.2) -> torch.Tensor:
        """True where no joint of the arm moves faster than this, rad/s; bool (B)."""
        return self.robot.get_qvel()[:, :_ARM_JOINTS].abs().amax(1) <= threshold

    def is_grasping(self, actor: Any = None, **_: Any) -> torch.Tensor:
        """True where it holds the task's object; bool (B).

        Raises:
            UnavailableError: The task has no such information.
        """
        for name in ("is_grasped", "is_ball_grasped"):
            grasped = self._env._view(name)
            if grasped is not None:
                return torch.from_numpy(np.array(grasped, np.bool_))
        raise UnavailableError(
            f"is_grasping: {self._env.task_id} has no such information; TimedTransfer, "
            "ShellGamePick and InterceptGrab have"
        )


class Panda(Agent):
    """The robot without a camera on its hand."""

    uid = "panda"


class PandaWristCam(Panda):
    """The robot with a camera on its hand."""

    uid = "panda_wristcam"


AGENTS = {cls.uid: cls for cls in (Panda, PandaWristCam)}
