"""The benchmark's wrappers around an environment, by id."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import gymnasium as gym

from engram.errors import InvalidArgumentError
from engram.mikasa import _families
from engram.mikasa.gym_utils import find_max_episode_steps_value
from engram.mikasa.ppo_memtasks import FlattenRGBDObservationWrapper
from engram.mikasa.wrappers import (
    ConvertJointsToEEFXyzRpyGripperWrapper,
    ConvertJointsToQposGripperWidthWrapper,
    CurriculumPhaseNoopActionWrapper,
    CurriculumPhaseNoopActionWrapperPdJointPos,
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
    StateOnlyTensorToDictWrapper,
)
from engram.tasks import list_tasks

__all__ = [
    "EXTENDED_WRAPPER_CONFIGS",
    "MIKASA_VLA_ENV_IDS",
    "VLA_WRAPPER_CONFIGS",
    "VLAWrapperConfig",
    "apply_mikasa_vla_wrappers",
]


@dataclass(frozen=True)
class VLAWrapperConfig:
    """Wrappers of an id.

    Attributes:
        overlays: Wrappers that draw over images, inner to outer.
        curriculum_wrapper: The wrapper that freezes actions while the cue is shown.
        expected_control_mode: Others bring a warning.
    """

    overlays: tuple[type, ...] = ()
    curriculum_wrapper: type | None = None
    expected_control_mode: str | None = None


STEP_REWARD_OVERLAYS = (RenderStepInfoWrapper, RenderRewardInfoWrapper)
SHELL_GAME_OVERLAYS = (
    RenderStepInfoWrapper,
    ShellGameRenderCupInfoWrapper,
    RenderRewardInfoWrapper,
)
INTERCEPT_OVERLAYS = STEP_REWARD_OVERLAYS
ROTATE_OVERLAYS = (*STEP_REWARD_OVERLAYS, RotateRenderAngleInfoWrapper)
COLOR_MEMORY_OVERLAYS = (RememberColorInfoWrapper, *STEP_REWARD_OVERLAYS)
SHAPE_MEMORY_OVERLAYS = (RememberShapeInfoWrapper, *STEP_REWARD_OVERLAYS)
SHAPE_COLOR_MEMORY_OVERLAYS = (RememberShapeAndColorInfoWrapper, *STEP_REWARD_OVERLAYS)
MEMORY_CAPACITY_OVERLAYS = (MemoryCapacityInfoWrapper, *STEP_REWARD_OVERLAYS)
BATTERIES_CHECKER_OVERLAYS = (RenderWorkingBatteriesInfoWrapper, *STEP_REWARD_OVERLAYS)
BLINK_COUNT_OVERLAYS = (RenderPressProgressInfoWrapper, *STEP_REWARD_OVERLAYS)
TRACE_SHAPE_OVERLAYS = (RenderTraceShapeDebugWrapper, *STEP_REWARD_OVERLAYS)
TIMED_TRANSFER_OVERLAYS = (RenderTimedTransferInfoWrapper, *STEP_REWARD_OVERLAYS)

_OVERLAYS: dict[str, tuple[type, ...]] = {
    **dict.fromkeys(_families.SHELL_GAMES, SHELL_GAME_OVERLAYS),
    **dict.fromkeys(_families.INTERCEPT, INTERCEPT_OVERLAYS),
    **dict.fromkeys(_families.ROTATE, ROTATE_OVERLAYS),
    **dict.fromkeys(_families.COLORS, COLOR_MEMORY_OVERLAYS),
    **dict.fromkeys(_families.SHAPES, SHAPE_MEMORY_OVERLAYS),
    **dict.fromkeys(_families.SHAPES_AND_COLORS, SHAPE_COLOR_MEMORY_OVERLAYS),
    **dict.fromkeys(_families.CAPACITY, MEMORY_CAPACITY_OVERLAYS),
    **dict.fromkeys(_families.BATTERIES, BATTERIES_CHECKER_OVERLAYS),
    **dict.fromkeys(_families.TRACE, TRACE_SHAPE_OVERLAYS),
    "TakeItBack": INTERCEPT_OVERLAYS,
    "BlinkCountButtonPress": BLINK_COUNT_OVERLAYS,
    "TimedTransfer": TIMED_TRANSFER_OVERLAYS,
    "GatherAndRecall": STEP_REWARD_OVERLAYS,
}
_FROZEN = (*_families.SHELL_GAMES, *_families.REMEMBER)


# Wrappers that freeze by holding a pose, by those that freeze by zeros.
_HOLDING: dict[type | None, type] = {
    CurriculumPhaseNoopActionWrapper: CurriculumPhaseNoopActionWrapperPdJointPos
}


def _configs(canonical: bool) -> dict[str, VLAWrapperConfig]:
    result = {}
    for task in list_tasks():
        of_original = task["id"].endswith("-VLA-v0") and task["family"] in _OVERLAYS
        if of_original and task["canonical"] == canonical:
            frozen = task["family"] in _FROZEN and "-Long" not in task["id"]
            freezes = CurriculumPhaseNoopActionWrapper if frozen else None
            result[task["id"]] = VLAWrapperConfig(_OVERLAYS[task["family"]], freezes)
    return result


# The benchmark's ids; users can add theirs.
VLA_WRAPPER_CONFIGS: dict[str, VLAWrapperConfig] = _configs(canonical=True)
# Chains of engram's own, for the original's VLA ids beyond its benchmark, which has none for them:
# those of their families.
EXTENDED_WRAPPER_CONFIGS: dict[str, VLAWrapperConfig] = _configs(canonical=False)
MIKASA_VLA_ENV_IDS = tuple(VLA_WRAPPER_CONFIGS)


def apply_mikasa_vla_wrappers(
    env: gym.Env[Any, Any], *, include_overlays: bool = True, joint_proprio: bool = False
) -> Any:
    """The environment with observations {"rgb", "proprio"[, "task_cue"]} for policies.

    Args:
        env: From gym.make, with obs_mode="rgb".
        include_overlays: True: ``render`` draws the answer over its images.
        joint_proprio: True: "proprio" has the arm's seven angles and the gripper's width, and with
            pd_joint_pos the arm holds its pose while actions are frozen, instead of going to zero
            angles. For policies of joints.

    Returns:
        The wrapped environment; it has also ``max_episode_steps``.

    Raises:
        InvalidArgumentError: The id is in neither VLA_WRAPPER_CONFIGS nor EXTENDED_WRAPPER_CONFIGS.
    """
    spec = env.spec or env.unwrapped.spec
    if spec is None or spec.id is None:
        raise InvalidArgumentError("env: it has no id; give one that gym.make made")
    config = VLA_WRAPPER_CONFIGS.get(spec.id) or EXTENDED_WRAPPER_CONFIGS.get(spec.id)
    if config is None:
        raise InvalidArgumentError(
            f"env: its id {spec.id!r} is not in VLA_WRAPPER_CONFIGS; add it, or use one of "
            f"{', '.join([*VLA_WRAPPER_CONFIGS, *EXTENDED_WRAPPER_CONFIGS])}"
        )
    base: Any = env.unwrapped
    expected = config.expected_control_mode
    if expected is not None and base.control_mode != expected:
        warnings.warn(
            f"{spec.id} expects control_mode {expected!r}; the environment has "
            f"{base.control_mode!r}",
            RuntimeWarning,
            stacklevel=2,
        )
    steps = find_max_episode_steps_value(env)
    wrapped: Any = StateOnlyTensorToDictWrapper(env)
    freezes = config.curriculum_wrapper
    if joint_proprio and base.control_mode == "pd_joint_pos":
        freezes = _HOLDING.get(freezes, freezes)
    if freezes is not None:
        wrapped = freezes(wrapped)
    for overlay in config.overlays if include_overlays else ():
        wrapped = overlay(wrapped)
    wrapped = FlattenRGBDObservationWrapper(wrapped, depth=False, state=False, joints=True)
    if joint_proprio:
        wrapped = ConvertJointsToQposGripperWidthWrapper(wrapped)
    else:
        wrapped = ConvertJointsToEEFXyzRpyGripperWrapper(wrapped)
    wrapped.max_episode_steps = steps
    return wrapped
