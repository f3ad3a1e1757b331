"""The RL half: what its families have in place of the VLA half's. Names are the original's."""

from __future__ import annotations

from collections.abc import Mapping

from engram.mikasa import _families

# --- classes ---

# Base classes; families with one id have none.
_BASES: Mapping[str, str] = {
    "Intercept": "InterceptBaseEnv",
    "InterceptGrab": "InterceptGrabBaseEnv",
    "RotateLenient": "RotateLanientEnv",  # as the original spells it
    "RotateStrict": "RotateStrictEnv",
    "RememberColor": "RememberColorBaseEnv",
    "RememberShape": "RememberShapeBaseEnv",
    "RememberShapeAndColor": "RememberShapeAndColorBaseEnv",
    **{family: f"{family}Env" for family in _families.CAPACITY},
}
_LEAVES: Mapping[str, str] = {
    "RememberShape5-v0": "RememberShape6Env",
    "RotateLenientPos-v0": "RotateLenientEnvPos",
    "RotateLenientPosNeg-v0": "RotateLenientEnvPosNeg",
    "RotateStrictPos-v0": "RotateStrictEnvPos",
    "RotateStrictPosNeg-v0": "RotateStrictEnvPosNeg",
}
# Constants that the class of an id has values of its own for; all others are its base's.
LEAF_CONSTANTS: Mapping[str, tuple[str, ...]] = {
    "RememberColor": ("COLORS",),
    **dict.fromkeys(("RememberShape", "RememberShapeAndColor"), ("SHAPES",)),
    **dict.fromkeys(_families.CAPACITY, ("SEQUENCE_LENGTH",)),
    **dict.fromkeys(_families.INTERCEPT, ("VELOCITY_RANGE",)),
    **dict.fromkeys(_families.ROTATE, ("MODE",)),
}


def base_name(family: str) -> str | None:
    """Name of a family's base class; None where it has none."""
    return _BASES.get(family)


def leaf_name(task: str) -> str:
    """Name of a task's class."""
    return _LEAVES.get(task, task.removesuffix("-v0") + "Env")


# --- constants ---

_REMEMBER = ("RememberColor", "RememberShape", "RememberShapeAndColor")
_CUE = {"TIME_OFFSET": "CUE_PHASE_STEPS"}
_CUE_AND_DELAY = {**_CUE, "EMPTY_DURATION": "EMPTY_PHASE_STEPS"}
_ITEMS = {"STEP_DURATION": "CUE_STEP_DURATION", "EMPTY_DURATION": "EMPTY_PHASE_STEPS"}
# Lengths of phases in control steps: the original's constants, and engram's, which are ranges.
PHASES: Mapping[str, Mapping[str, str]] = {
    **dict.fromkeys(("ShellGameTouch", "ShellGamePush", "ShellGamePick", *_REMEMBER), _CUE),
    "BunchOfColors": _CUE_AND_DELAY,
    "SeqOfColors": _ITEMS,
    "ChainOfColors": _ITEMS,
}


# Constants by keywords of gym.make; "" has no effect, as in the original.
KEYWORDS: Mapping[str, Mapping[str, str]] = {
    **{family: {"delta_time": "EMPTY_PHASE_STEPS"} for family in _REMEMBER},
    **{family: {"delta_time": ""} for family in _families.CAPACITY},
}
