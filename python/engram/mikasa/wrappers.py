"""The original's wrappers under their names: observations, frozen actions; overlays come along."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np

from engram.errors import InvalidArgumentError
from engram.mikasa import _families
from engram.mikasa._base_wrappers import ActionWrapper, ObservationWrapper, Wrapper
from engram.mikasa._torch import torch
from engram.mikasa.overlays import (
    DebugRewardWrapper,
    MemoryCapacityInfoWrapper,
    RememberColorInfoWrapper,
    RememberShapeAndColorInfoWrapper,
    RememberShapeInfoWrapper,
    RenderPressProgressInfoWrapper,
    RenderRewardInfoWrapper,
    RenderStepInfoWrapper,
    RenderTimedTransferInfoWrapper,
    RenderTraceShapeDebugWrapper,
    RenderWorkingBatteriesInfoWrapper,
    RotateRenderAngleInfoWrapper,
    ShellGameRenderCupInfoWrapper,
)

__all__ = [
    "CameraShutdownWrapper",
    "ConvertJointsToEEFXyzRpyGripperWrapper",
    "CurriculumPhaseNoopActionWrapper",
    "CurriculumPhaseNoopActionWrapperPdJointPos",
    "DebugRewardWrapper",
    "InitialZeroActionWrapper",
    "MemoryCapacityInfoWrapper",
    "RememberColorInfoWrapper",
    "RememberShapeAndColorInfoWrapper",
    "RememberShapeInfoWrapper",
    "RenderPressProgressInfoWrapper",
    "RenderRewardInfoWrapper",
    "RenderStepInfoWrapper",
    "RenderTimedTransferInfoWrapper",
    "RenderTraceShapeDebugWrapper",
    "RenderWorkingBatteriesInfoWrapper",
    "RotateRenderAngleInfoWrapper",
    "ShellGameRenderCupInfoWrapper",
    "StateOnlyTensorToDictWrapper",
]

NOTHING = 4242424242  # in place of a cue or an answer that there is not
_TCP = 7
_JOINTS = 9
_LEAST_NORM = 1e-8


class StateOnlyTensorToDictWrapper(ObservationWrapper):
    """Observations become dicts that hold also task_cue and oracle_info.

    Both are (B, n); where a task has none, (B, 1) full of 4242424242. Of the cue that the lamps and
    TraceShapeSeq have, which is the answer, pictures come without.
    """

    def observation(self, observation: Any) -> dict[str, Any]:
        """The dict; that of obs_mode "state" holds the row as "state"."""
        result = observation if isinstance(observation, dict) else {"state": observation}
        base: Any = self.unwrapped
        cue = base.task_cue if _may_tell_cue(base) else None
        result["task_cue"] = _column(cue, base.num_envs)
        result["oracle_info"] = _column(base.oracle_info, base.num_envs)
        return result


def _may_tell_cue(base: Any) -> bool:
    return base._family in _families.ROTATE or base.obs_mode in ("state", "state_dict")


def _column(value: torch.Tensor | None, count: int) -> torch.Tensor:
    if value is None:
        return torch.full((count, 1), float(NOTHING))
    return value.unsqueeze(-1) if value.ndim == 1 else value


class ConvertJointsToEEFXyzRpyGripperWrapper(ObservationWrapper):
    """Makes of joints (B, 25) what policies see: tool x, y, z, roll, pitch, yaw, gripper opening.

    Args:
        env: Whose observations hold "proprio": tool pose 7, joint positions, joint velocities.
        qpos_dim: Joint positions in it; None: as many as the robot has.
        gripper_finger_dims: How many of them are fingers: the last ones.
    """

    def __init__(
        self,
        env: gym.Env[Any, Any],
        qpos_dim: int | None = None,
        gripper_finger_dims: int = 2,
    ) -> None:
        super().__init__(env)
        self.gripper_finger_dims = gripper_finger_dims
        base: Any = self.unwrapped
        if qpos_dim is None:
            qpos_dim = int(base.agent.robot.get_qpos().shape[-1])
        self.qpos_dim = qpos_dim
        if isinstance(base._init_raw_obs, dict) and "proprio" in base._init_raw_obs:
            self._update_space(self.observation(base._init_raw_obs))

    def observation(self, observation: Any) -> Any:
        """The observation with the shorter proprio; one of 7 numbers stays."""
        proprio = observation.get("proprio") if isinstance(observation, dict) else None
        if proprio is None or proprio.shape[-1] == _TCP:
            return observation
        least = _TCP + self.qpos_dim
        if proprio.shape[-1] < least:
            raise InvalidArgumentError(
                f"proprio: {proprio.shape[-1]} numbers given; 7, or at least {least} needed"
            )
        given = torch.as_tensor(proprio)
        result = self._own(given)
        if result is None:
            result = end_effector(
                given[..., :_TCP], given[..., least - self.gripper_finger_dims : least]
            )
        changed = result if isinstance(proprio, torch.Tensor) else result.numpy()
        return {**observation, "proprio": changed}

    def _own(self, joints: torch.Tensor) -> torch.Tensor | None:
        """What the core made of these joints, if they are the present ones.

        It is the same but for rounding, which decides between the two signs of a roll of pi, and
        policies should see here what they see in ``engram eval``.
        """
        base: Any = self.unwrapped
        view = base._view("proprio")
        if self.qpos_dim != _JOINTS or self.gripper_finger_dims != 2 or view is None:
            return None
        core = torch.from_numpy(view)
        if not torch.equal(core[:, :3], joints[..., :3]):
            return None
        return core.clone()


def end_effector(pose: torch.Tensor, fingers: torch.Tensor) -> torch.Tensor:
    """Position, fixed-axis roll, pitch, yaw, and the sum of the fingers: (..., 7) float32."""
    q = pose[..., 3:7]
    w, x, y, z = (q / q.norm(dim=-1, keepdim=True).clamp_min(_LEAST_NORM)).unbind(-1)
    roll = torch.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = torch.asin((2 * (w * y - z * x)).clamp(-1, 1))
    yaw = torch.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    parts = [pose[..., :3], torch.stack([roll, pitch, yaw, fingers.sum(-1)], dim=-1)]
    return torch.cat(parts, dim=-1).to(torch.float32)


class CurriculumPhaseNoopActionWrapper(ActionWrapper):
    """Actions are zeros while the cue is shown and the table is empty, in each environment.

    It does nothing where a task has no cue.
    """

    def action(self, action: Any) -> Any:
        """The action, or a copy with rows replaced."""
        frozen = self._frozen()
        if frozen is None or not bool(frozen.any()):
            return action
        count = len(frozen)
        if isinstance(action, torch.Tensor):
            given = action.expand(count, -1) if action.ndim == 1 else action
            changed = given.clone()
            changed[frozen.to(changed.device)] = self._held(changed)[frozen].to(changed)
            return changed
        array = np.array(action)
        if array.ndim == 1:
            array = np.repeat(array[np.newaxis], count, axis=0)
        rows = frozen.numpy()
        array[rows] = self._held(torch.as_tensor(array)).numpy()[rows]
        return array

    def _frozen(self) -> torch.Tensor | None:
        base: Any = self.unwrapped
        until = getattr(base, "cue_steps_per_env", None)
        if until is None or self.current_steps is None:
            return None
        empty = getattr(base, "empty_steps_per_env", None)
        if empty is not None:
            until = until + empty
        frozen: torch.Tensor = self.current_steps < until
        return frozen

    def _held(self, actions: torch.Tensor) -> torch.Tensor:
        """What frozen environments do, of the shape of these actions."""
        return torch.zeros_like(actions)


class CurriculumPhaseNoopActionWrapperPdJointPos(CurriculumPhaseNoopActionWrapper):
    """The same for pd_joint_pos, where zeros are a pose: the frozen hold the one they have."""

    GRIPPER_LOW = -0.01
    GRIPPER_HIGH = 0.04

    def _held(self, actions: torch.Tensor) -> torch.Tensor:
        base: Any = self.unwrapped
        qpos = base.agent.robot.get_qpos()
        middle = (self.GRIPPER_HIGH + self.GRIPPER_LOW) / 2
        half = (self.GRIPPER_HIGH - self.GRIPPER_LOW) / 2
        gripper = ((qpos[:, -2:-1] - middle) / half).clamp(-1, 1)
        return torch.cat([qpos[:, :-2], gripper], dim=1).to(actions.dtype)


class InitialZeroActionWrapper(ActionWrapper):
    """Actions are zeros in the first steps of an episode.

    Args:
        env: The environment.
        n_initial_steps: How many.
    """

    def __init__(self, env: gym.Env[Any, Any], n_initial_steps: int = 1) -> None:
        super().__init__(env)
        self.n_initial_steps = n_initial_steps

    def action(self, action: Any) -> Any:
        """The action, or a copy with rows of zeros; batches of tensors only."""
        if self.current_steps is None:
            return action
        first = self.current_steps < self.n_initial_steps
        if not bool(first.any()):
            return action
        changed = torch.as_tensor(action).clone()
        changed[first.to(changed.device)] = 0
        return changed


class CameraShutdownWrapper(Wrapper):
    """Cameras see black, all of them, once an environment has had so many steps.

    Args:
        env: The environment, before its observations are flattened.
        n_initial_steps: How many steps they work.
    """

    def __init__(self, env: gym.Env[Any, Any], n_initial_steps: int = 19) -> None:
        super().__init__(env)
        self.n_initial_steps = n_initial_steps

    def step(self, action: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """As of the environment within."""
        result = self.env.step(action)
        if bool((result[4]["elapsed_steps"] > self.n_initial_steps).any()):
            for pictures in result[0]["sensor_data"].values():
                for picture in pictures.values():
                    picture.zero_()
        return result
