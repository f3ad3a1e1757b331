"""Constructors of the families that take keywords of their own."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from engram.mikasa import _families, _rl_families
from engram.mikasa.env import BaseEnv

_ANGLE_THRESHOLD = 0.1  # rad


def of_family(family: str, *, rl: bool) -> dict[str, Callable[..., None]]:
    """Attributes of a base class: its constructor, if it is not that of ``BaseEnv``."""
    if family in _families.ROTATE:
        return {"__init__": _rotate}
    if family == "BlinkCountButtonPress":
        return {"__init__": _blink}
    if rl and family in _rl_families.KEYWORDS:
        return {"__init__": _delayed}
    return {}


def _rotate(
    self: BaseEnv,
    num_envs: int = 1,
    *,
    robot_uids: str = "panda_wristcam",
    robot_init_qpos_noise: float = 0.02,
    reconfiguration_freq: int | None = None,
    angle_threshold: float = _ANGLE_THRESHOLD,
    **keywords: Any,
) -> None:
    """See BaseEnv; angle_threshold: rad, error within which the peg has turned far enough."""
    if angle_threshold != _ANGLE_THRESHOLD:
        keywords["angle_threshold"] = angle_threshold
    _make(self, num_envs, robot_uids, robot_init_qpos_noise, reconfiguration_freq, keywords)


def _blink(
    self: BaseEnv,
    num_envs: int = 1,
    *,
    robot_uids: str = "panda_wristcam",
    robot_init_qpos_noise: float = 0.02,
    reconfiguration_freq: int | None = None,
    blink_color: Any = None,
    **keywords: Any,
) -> None:
    """See BaseEnv; blink_color: None, the lamp has one colour."""
    keywords["blink_color"] = blink_color
    _make(self, num_envs, robot_uids, robot_init_qpos_noise, reconfiguration_freq, keywords)


def _delayed(
    self: BaseEnv,
    num_envs: int = 1,
    *,
    robot_uids: str = "panda_wristcam",
    robot_init_qpos_noise: float = 0.02,
    reconfiguration_freq: int | None = None,
    delta_time: int | None = None,
    **keywords: Any,
) -> None:
    """See BaseEnv; delta_time: control steps between cue and question; None: the task's."""
    if delta_time is not None:
        keywords["delta_time"] = delta_time
    _make(self, num_envs, robot_uids, robot_init_qpos_noise, reconfiguration_freq, keywords)


def _make(
    env: BaseEnv,
    num_envs: int,
    robot_uids: str,
    noise: float,
    reconfiguration_freq: int | None,
    keywords: dict[str, Any],
) -> None:
    BaseEnv.__init__(
        env,
        num_envs,
        robot_uids=robot_uids,
        robot_init_qpos_noise=noise,
        reconfiguration_freq=reconfiguration_freq,
        **keywords,
    )
