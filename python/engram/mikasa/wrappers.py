"""The original's wrappers under their names: observations, frozen actions; overlays come along."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np

from engram.errors import InvalidArgumentError
from engram.mikasa import _families
from engram.mikasa._base_wrappers import ActionWrapper, ObservationWrapper, Wrapper, source
from engram.mikasa._observing import Wanted
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
    "ConvertJointsToQposGripperWidthWrapper",
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
_FINGERS = 2
_LEAST_NORM = 1e-8


class StateOnlyTensorToDictWrapper(ObservationWrapper):
    """Observations become dicts that hold also task_cue and oracle_info.

    Both are (B, n); where a task has none, (B, 1) full of 4242424242. Observations with images lack
    the cue of the lamps and of TraceShapeSeq, which is the answer.
    """

    _passes_parts = True

    def observation(self, observation: Any) -> dict[str, Any]:
        """The dict; that of obs_mode "state" holds the row as "state"."""
        base: Any = self.unwrapped
        cue = base.task_cue if _has_cue(base) else None
        if base._observations.wanted is Wanted.POLICY:
            extra = {} if cue is None else {"task_cue": _column(cue, base.num_envs)}
            return {**extra, **observation}
        result = observation if isinstance(observation, dict) else {"state": observation}
        result["task_cue"] = _column(cue, base.num_envs)
        result["oracle_info"] = _column(base.oracle_info, base.num_envs)
        return result


def _has_cue(base: Any) -> bool:
    return base._family in _families.ROTATE or base.obs_mode in ("state", "state_dict")


def _column(value: torch.Tensor | None, count: int) -> torch.Tensor:
    if value is None:
        return torch.from_numpy(np.full((count, 1), NOTHING, np.float32))
    return value.unsqueeze(-1) if value.ndim == 1 else value


class ConvertJointsToEEFXyzRpyGripperWrapper(ObservationWrapper):
    """Converts joints (B, 25) to tool x, y, z, roll, pitch, yaw, gripper opening.

    Args:
        env: Whose observations hold "proprio": tool pose 7, joint positions, joint velocities.
        qpos_dim: Joint positions in it; None: as many as the robot has.
        gripper_finger_dims: How many of them are fingers: the last ones.
    """

    _needs = Wanted.POLICY

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
        self._source = self._policy_source()

    def _policy_source(self) -> Any:
        """Source of observations, if only the benchmark's own wrappers are in between.

        It can then make the observations of policies directly.
        """
        flat: Any = self.env
        own = type(self) is ConvertJointsToEEFXyzRpyGripperWrapper and self._usual
        if not (own and vars(flat).get("_of_policies") and source(flat, Wanted.NO_MATRICES)):
            return None
        found = source(flat.env, Wanted.POLICY)
        return found if found is not None and tuple(found.textures) == ("rgb",) else None

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

    @property
    def _usual(self) -> bool:
        return self.qpos_dim == _JOINTS and self.gripper_finger_dims == _FINGERS

    def _own(self, joints: torch.Tensor) -> torch.Tensor | None:
        """The core's result for these joints, if they are the present ones.

        It differs by rounding only, which decides the sign of a roll of pi; policies get the same
        as in ``engram eval``.
        """
        base: Any = self.unwrapped
        view = base._view("proprio")
        if not self._usual or view is None:
            return None
        if not np.array_equal(view[:, :3], joints.numpy()[..., :3]):
            return None
        return torch.from_numpy(view.copy())


class ConvertJointsToQposGripperWidthWrapper(ObservationWrapper):
    """Converts joints (B, 25) to the arm's seven angles, rad, and the gripper's width, m.

    Args:
        env: Whose observations hold "proprio": tool pose 7, joint positions 9, joint velocities 9.
    """

    _needs = Wanted.NO_MATRICES

    def __init__(self, env: gym.Env[Any, Any]) -> None:
        super().__init__(env)
        base: Any = self.unwrapped
        if isinstance(base._init_raw_obs, dict) and "proprio" in base._init_raw_obs:
            self._update_space(self.observation(base._init_raw_obs))

    def observation(self, observation: Any) -> Any:
        """The observation with the shorter proprio; one of 8 numbers stays."""
        proprio = observation.get("proprio") if isinstance(observation, dict) else None
        arm = _JOINTS - _FINGERS
        if proprio is None or proprio.shape[-1] == arm + 1:
            return observation
        if proprio.shape[-1] < _TCP + _JOINTS:
            raise InvalidArgumentError(
                f"proprio: {proprio.shape[-1]} numbers given; {arm + 1}, or at least "
                f"{_TCP + _JOINTS} needed"
            )
        qpos = torch.as_tensor(proprio)[..., _TCP : _TCP + _JOINTS]
        width = qpos[..., arm:].sum(-1, keepdim=True)
        result = torch.cat([qpos[..., :arm], width], dim=-1).to(torch.float32)
        changed = result if isinstance(proprio, torch.Tensor) else result.numpy()
        return {**observation, "proprio": changed}


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

    _episodes: Any = None  # values drawn for them
    _until: np.ndarray | None = None  # when their cue ends; None if that is over

    def action(self, action: Any) -> Any:
        """The action, or a copy with rows replaced."""
        frozen = self._frozen()
        if frozen is None or action is None:
            return action
        given = action.detach().cpu().numpy() if isinstance(action, torch.Tensor) else action
        array = np.array(given)
        if array.ndim == 1:
            array = np.repeat(array[np.newaxis], len(frozen), axis=0)
        array[frozen] = self._held(array)[frozen]
        if isinstance(action, torch.Tensor):
            return torch.from_numpy(array).to(action.device)
        return array

    def _frozen(self) -> np.ndarray | None:
        """Frozen environments; None if there are none."""
        if self.current_steps is None:
            return None
        base: Any = self.unwrapped
        if base._drawn is None or base._drawn is not self._episodes:
            self._until = _end_of_cue(base)
            self._episodes = base._drawn
        if self._until is None:
            return None
        frozen: np.ndarray = self.current_steps.numpy() < self._until
        if frozen.any():
            return frozen
        self._until = None  # until episodes begin, this stays so
        return None

    def _held(self, actions: np.ndarray) -> np.ndarray:
        """Actions of frozen environments, of the shape of these actions."""
        return np.zeros_like(actions)


def _end_of_cue(base: Any) -> np.ndarray | None:
    """The step from which on robots may act; None where a task has no cue."""
    cue = getattr(base, "cue_steps_per_env", None)
    if cue is None:
        return None
    empty = getattr(base, "empty_steps_per_env", None)
    end: np.ndarray = cue.numpy() if empty is None else cue.numpy() + empty.numpy()
    return end


class CurriculumPhaseNoopActionWrapperPdJointPos(CurriculumPhaseNoopActionWrapper):
    """Freezes pd_joint_pos, where zeros are a pose: the frozen hold the one they have."""

    GRIPPER_LOW = -0.01
    GRIPPER_HIGH = 0.04

    def _held(self, actions: np.ndarray) -> np.ndarray:
        base: Any = self.unwrapped
        qpos = base.agent.robot.get_qpos().numpy()
        middle = (self.GRIPPER_HIGH + self.GRIPPER_LOW) / 2
        half = (self.GRIPPER_HIGH - self.GRIPPER_LOW) / 2
        gripper = np.clip((qpos[:, -2:-1] - middle) / half, -1, 1)
        return np.concatenate([qpos[:, :-2], gripper], axis=1).astype(actions.dtype)


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
        if self.current_steps is None or action is None:
            return action
        first = self.current_steps < self.n_initial_steps
        if not bool(first.any()):
            return action
        changed = torch.as_tensor(action).clone()
        changed[first.to(changed.device)] = 0
        return changed


class CameraShutdownWrapper(Wrapper):
    """Images of all cameras are black after a number of steps.

    Args:
        env: The environment, before its observations are flattened.
        n_initial_steps: How many steps they work.
    """

    def __init__(self, env: gym.Env[Any, Any], n_initial_steps: int = 19) -> None:
        super().__init__(env)
        self.n_initial_steps = n_initial_steps

    def step(self, action: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """See the wrapped environment."""
        result = self.env.step(action)
        if bool((result[4]["elapsed_steps"] > self.n_initial_steps).any()):
            for images in result[0]["sensor_data"].values():
                for image in images.values():
                    image.zero_()
        return result
