"""Families of tasks: keys of infos, types of infos and observations, classes.

Names are the original's. A family is the ``family`` of ``engram.describe``.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from engram.mikasa._torch import torch
from engram.typing import TaskDescription

SHELL_GAMES = (
    "ShellGameTouch",
    "ShellGamePush",
    "ShellGamePick",
    "ShellGameColorLampTouch",
    "ShellGameShuffleTouch",
    "ShellGameShuffleColorLampTouch",
)
LAMPS = ("ShellGameColorLampTouch", "ShellGameShuffleColorLampTouch")
COLORS = ("RememberColor", "FindImposterColor")
SHAPES = ("RememberShape", "FindImposterShape")
SHAPES_AND_COLORS = ("RememberShapeAndColor", "FindImposterShapeAndColor")
REMEMBER = (*COLORS, *SHAPES, *SHAPES_AND_COLORS)
CAPACITY = ("BunchOfColors", "SeqOfColors", "ChainOfColors")
INTERCEPT = ("Intercept", "InterceptGrab")
ROTATE = ("RotateLenient", "RotateStrict")
TRACE = ("TraceShape", "TraceShapeSeq")
BATTERIES = ("BatteriesCheckerEasy", "BatteriesCheckerHard")

# --- infos ---

# Outputs that all tasks have.
_COMMON = frozenset(
    [
        *("observation", "proprio", "reward", "terminated", "truncated", "unstable", "success"),
        *("failed", "elapsed_steps", "success_once", "episode_return", "oracle_info", "task_cue"),
        *("answered", "first_answer", "first_answer_correct", "reward_dict"),
    ]
)
# Families whose infos say whether an episode has failed.
_FAILING = ("TimedTransfer", "GatherAndRecall", "BlinkCountButtonPress")


def info_keys(description: TaskDescription) -> list[str]:
    """Keys of infos that are outputs of the task."""
    own = [output["name"] for output in description["outputs"] if output["name"] not in _COMMON]
    failed = ["failed"] if description["family"] in _FAILING else []
    return ["success", *failed, *own]


# --- types ---

# Types of the answer; uint8 for all other families.
_ORACLE_TYPES: Mapping[str, torch.dtype] = {
    **dict.fromkeys((*ROTATE, *INTERCEPT, "TimedTransfer", "TakeItBack"), torch.float32),
    "TraceShapeSeq": torch.int64,
}
# Types of the cue; all other families have none.
_CUE_TYPES: Mapping[str, torch.dtype] = {
    **dict.fromkeys(ROTATE, torch.float16),
    **dict.fromkeys(LAMPS, torch.uint8),
    "TraceShapeSeq": torch.int64,
}
# Types of state fields that are neither infos nor floats.
_FIELD_TYPES: Mapping[str, torch.dtype] = {
    "target_color": torch.uint8,
    "sequence_len": torch.int64,
    "active_mask": torch.bool,
    "cubes_on_disc": torch.bool,
}
# Types of reward terms that are conditions or counts; all others are float32.
_TARGET_TERMS = dict.fromkeys(("is_robot_static", "reached", "success"), torch.bool)
_SHELL_TERMS = dict.fromkeys(
    (
        "is_obj_placed",
        'info["is_obj_placed"]',
        'info["is_grasped"]',
        "is_mug_displacement_ok",
        "is_robot_static",
        "reached_status",
    ),
    torch.bool,
)
_CAPACITY_TERMS = {
    **dict.fromkeys(
        ("all_seq_touched", "no_extra_touched", "is_robot_static", "strong_cube_displacement"),
        torch.bool,
    ),
    **dict.fromkeys(
        (
            "correct_touches",
            "correct_touches_in_order",
            "wrong_touches",
            "touched_cubes",
            "sequence_cubes_mask",
        ),
        torch.int64,
    ),
}
_ROTATE_TERMS = dict.fromkeys(
    (
        "agent_is_static",
        "correct_angle",
        "self.correct_angle",
        "position_ok",
        "reached_status",
        "success",
    ),
    torch.bool,
)
_REWARD_TYPES: Mapping[str, Mapping[str, torch.dtype]] = {
    **dict.fromkeys(REMEMBER, _TARGET_TERMS),
    **dict.fromkeys(SHELL_GAMES, _SHELL_TERMS),
    **dict.fromkeys(CAPACITY, _CAPACITY_TERMS),
    **dict.fromkeys(ROTATE, _ROTATE_TERMS),
    "Intercept": {"reached_status": torch.bool},
    "InterceptGrab": dict.fromkeys(
        (
            "ball_in_gripper",
            "is_grasped_reward",
            "robot_static_reward",
            "success",
            "very_close_mask",
        ),
        torch.bool,
    ),
    "TakeItBack": dict.fromkeys(
        ("goal_achieved", "goal_reached_status", "reached_pull", "reached_push"), torch.bool
    ),
}


def reward_type(term: str, family: str) -> torch.dtype:
    """Type of a term of ``reward_dict``."""
    return _REWARD_TYPES.get(family, {}).get(term, torch.float32)


def oracle_type(family: str) -> torch.dtype:
    """Type of ``oracle_info``."""
    return _ORACLE_TYPES.get(family, torch.uint8)


def cue_type(family: str) -> torch.dtype | None:
    """Type of ``task_cue``; None for families that have none."""
    return _CUE_TYPES.get(family)


def field_type(name: str, family: str) -> torch.dtype | None:
    """Type of a field of ``state_dict`` that is no info; None: as it is, float32."""
    if name == "oracle_info":
        return oracle_type(family)
    if name.startswith(("touched_", "next_target_")) or name.endswith("_in_seq"):
        return torch.bool
    return _FIELD_TYPES.get(name)


def is_row(name: str, family: str) -> bool:
    """True for fields that keep their second dimension at width 1: lists of one element."""
    if name == "oracle_info":
        return family in CAPACITY + BATTERIES
    return name == "cubes_on_disc"


# --- classes ---

# Constants of base classes that differ from those of the first task of the family.
BASE_CONSTANTS: Mapping[str, Mapping[str, Any]] = {
    **{family: {"SEQUENCE_LENGTH": 5} for family in CAPACITY},
    "GatherAndRecall": {"N_CUBES": 5},
    **{family: {"VELOCITY_RANGE": [0.0, 0.0]} for family in INTERCEPT},
    "BlinkCountButtonPress": {
        "BLINK_COUNT_RANGE": [1, 5],
        "PRE_BLINK_OFF_STEPS": [2, 4],
        "BLINK_ON_STEPS": [1, 2],
        "BLINK_OFF_STEPS": [2, 4],
    },
    **{f: {"ACTIVE_BATTERY_COUNT": 15, "WORKING_BATTERY_COUNT": 3} for f in BATTERIES},
}

_CUE = ("CUE_PHASE_STEPS",)
_CUE_AND_DELAY = ("CUE_PHASE_STEPS", "EMPTY_PHASE_STEPS")
_ITEMS = ("SEQUENCE_LENGTH", "CUE_STEP_DURATION", "EMPTY_PHASE_STEPS")
# Constants that the class of an id has values of its own for; all others are its base's.
LEAF_CONSTANTS: Mapping[str, tuple[str, ...]] = {
    **dict.fromkeys(COLORS, ("COLORS", *_CUE_AND_DELAY)),
    **dict.fromkeys((*SHAPES, *SHAPES_AND_COLORS), ("SHAPES", *_CUE_AND_DELAY)),
    "BunchOfColors": ("SEQUENCE_LENGTH", *_CUE_AND_DELAY),
    **dict.fromkeys(("SeqOfColors", "ChainOfColors"), _ITEMS),
    **dict.fromkeys(SHELL_GAMES, _CUE),
    **dict.fromkeys(
        ("ShellGameShuffleTouch", "ShellGameShuffleColorLampTouch"),
        (*_CUE, "SHUFFLE_PHASE_STEPS", "NUM_SWAPS"),
    ),
    **dict.fromkeys(INTERCEPT, ("VELOCITY_RANGE",)),
    **dict.fromkeys(ROTATE, ("MODE",)),
    "TakeItBack": (),
    "TimedTransfer": ("DELAY_STEPS",),
    "BlinkCountButtonPress": tuple(BASE_CONSTANTS["BlinkCountButtonPress"]),
    **dict.fromkeys(TRACE, ("AVAILABLE_SHAPES",)),
    "GatherAndRecall": ("N_CUBES",),
    **dict.fromkeys(BATTERIES, ("ACTIVE_BATTERY_COUNT", "WORKING_BATTERY_COUNT")),
}


def base_name(family: str) -> str:
    """Name of a family's base class."""
    return ("BatteriesChecker" if family == "BatteriesCheckerHard" else family) + "VLABaseEnv"


def leaf_name(task: str) -> str:
    """Name of a task's class."""
    stem = task.removesuffix("-v0").replace("BatteriesCheckerHard-", "BatteriesChecker-")
    return stem.removesuffix("VLA").replace("-", "") + "VLAEnv"
