"""The keywords of gym.make: each served, ignored with one warning, or refused with a reason."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from engram._args.values import integer, nearest, one_of, real
from engram.errors import InvalidArgumentError, UnavailableError
from engram.mikasa._torch import torch
from engram.typing import RewardMode, Rules

_OBS_MODES = (
    "state",
    "state_dict",
    "none",
    "rgb",
    "rgbd",
    "rgb+depth",
    "rgb+segmentation",
    "rgb+depth+segmentation",
)
_REWARD_MODES = ("normalized_dense", "dense", "sparse", "none")
# "cameras" is the name that "sensors" had before; programs still use it.
RENDER_MODES = ("rgb_array", "sensors", "cameras", "all")
_CONTROL_MODE = "pd_joint_delta_pos"
_RULES = ("original", "reference")
_SIZES = ("width", "height")

# Devices and rendering for people, without effect on episodes.
_IGNORED = {
    "render_backend": "images are rendered on the CPU",
    "shader_dir": "there is one shader",
    "viewer_camera_configs": "there is no viewer",
    "enhanced_determinism": "all results are deterministic",
}
_REFUSED = {
    "sim_config": "engram's physics has no such settings",
    "parallel_in_single_scene": "environments do not share a scene",
}


@dataclass
class Settings:
    """Settings of an environment."""

    num_envs: int
    obs_mode: str
    control_mode: Any
    reward_mode: RewardMode
    render_mode: str | None
    reconfiguration_freq: int
    robot_uids: str
    rules: Rules
    image_size: tuple[int, int]
    render_size: tuple[int, int]
    options: dict[str, Any] = field(default_factory=dict)  # further ones of engram.VectorEnv

    @property
    def cameras(self) -> list[str]:
        """Sensors, in channel order."""
        both = ["base_camera", "hand_camera"]
        return both if self.robot_uids == "panda_wristcam" else both[:1]

    @property
    def textures(self) -> tuple[str, ...]:
        """Images of the cameras, a subset of "rgb", "depth", "segmentation"."""
        if not self.obs_mode.startswith("rgb"):
            return ()
        return tuple(self.obs_mode.replace("rgbd", "rgb+depth").split("+"))


_NONE: Mapping[str, str] = {}
_warned: set[str] = set()


def _warn_once(text: str) -> None:
    if text not in _warned:
        _warned.add(text)
        warnings.warn(text, stacklevel=2)


def _name(what: str, value: Any, default: str | None, allowed: tuple[str, ...]) -> Any:
    if value is None:
        return default
    one_of(what, value, dict.fromkeys(allowed, 0))
    return value


def read(
    given: Mapping[str, Any], *, takes: tuple[str, ...], constants: Mapping[str, str] = _NONE
) -> Settings:
    """Settings from keywords.

    Args:
        given: Keywords of gym.make, without the id.
        takes: Keywords of the task.
        constants: Those of them that are numbers of control steps, and the constants of engram that
            they set; "": none.

    Raises:
        TypeError: A keyword is unknown.
        InvalidArgumentError: A value is refused; the message says why.
    """
    left = dict(given)
    own = {name: left.pop(name) for name in takes if name in left}
    num_envs = integer("num_envs", left.pop("num_envs", 1), 1, 1_000_000)
    settings = Settings(
        num_envs=num_envs,
        obs_mode=_obs_mode(left.pop("obs_mode", None)),
        control_mode=left.pop("control_mode", None) or _CONTROL_MODE,
        reward_mode=_name(
            "reward_mode", left.pop("reward_mode", None), _REWARD_MODES[0], _REWARD_MODES
        ),
        render_mode=_render_mode(left.pop("render_mode", None)),
        reconfiguration_freq=_frequency(left.pop("reconfiguration_freq", None)),
        robot_uids=_robot(left.pop("robot_uids", "panda_wristcam")),
        rules=_rules(left.pop("rules", None)),
        image_size=_sensor_size(left.pop("sensor_configs", None)),
        render_size=_render_size(left.pop("human_render_camera_configs", None)),
    )
    options = settings.options
    options["robot_init_qpos_noise"] = real(
        "robot_init_qpos_noise", left.pop("robot_init_qpos_noise", 0.02)
    )
    for name, keyword in (("enable_shadow", "shadows"), ("threads", "threads")):
        if name in left:
            options[keyword] = left.pop(name)
    options["constants"] = _task_constants(own, constants)
    if settings.robot_uids != "panda_wristcam":
        options["constants"]["robot_uids"] = settings.robot_uids
    _check_backend(left.pop("sim_backend", "auto"), num_envs)
    for name, why in _IGNORED.items():
        if name in left and left.pop(name) is not None:
            _warn_once(f"{name} has no effect: {why}")
    for name, why in _REFUSED.items():
        value = left.pop(name, None)
        if value is not None and value is not False and value != {}:
            raise InvalidArgumentError(f"{name}: {value!r} given; {why}; allowed: None")
    if left:
        raise _unexpected(next(iter(left)), takes)
    return settings


def _unexpected(name: str, takes: tuple[str, ...]) -> TypeError:
    known = [
        *("num_envs", "obs_mode", "control_mode", "reward_mode", "render_mode", "sim_backend"),
        *("reconfiguration_freq", "robot_uids", "robot_init_qpos_noise", "sensor_configs"),
        *("human_render_camera_configs", "enable_shadow", "rules", "threads", "max_episode_steps"),
        *(*_IGNORED, *_REFUSED, *takes),
    ]
    meant = nearest(name, known)
    hint = "" if meant is None else f". Did you mean '{meant}'?"
    return TypeError(f"gym.make() got an unexpected keyword argument '{name}'{hint}")


def _obs_mode(value: Any) -> str:
    if isinstance(value, str) and value not in _OBS_MODES:
        raise InvalidArgumentError(
            f"obs_mode: {value!r} given; engram's cameras have rgb, depth and segmentation; "
            f"allowed: {', '.join(_OBS_MODES)}"
        )
    return str(_name("obs_mode", value, "state", _OBS_MODES))


def _render_mode(value: Any) -> str | None:
    if value == "human":
        raise UnavailableError(
            "render_mode: 'human' given; there is no viewer; "
            f"allowed: {', '.join(RENDER_MODES)}, None"
        )
    mode: str | None = _name("render_mode", value, None, RENDER_MODES)
    return mode


def _rules(value: Any) -> Any:
    """The rule set of a keyword, or of ENGRAM_RULES; the first choice without either is said."""
    name, chosen = "rules", value
    if value is None:
        name, chosen = "ENGRAM_RULES", os.environ.get("ENGRAM_RULES") or None
    if chosen is None and _RULES[0] not in _warned:
        _warned.add(_RULES[0])
        print(
            "engram.mikasa: rules of the original's code; rules='reference' in gym.make, or "
            "ENGRAM_RULES=reference, has those of its documentation",
            file=sys.stderr,
        )
    return _name(name, chosen, _RULES[0], _RULES)


def _frequency(value: Any) -> int:
    return 0 if value is None else integer("reconfiguration_freq", value, 0)


def _robot(value: Any) -> str:
    if isinstance(value, (tuple, list)) and len(value) == 1:
        value = value[0]
    if value not in ("panda", "panda_wristcam"):
        raise NotImplementedError(f"robot_uids: {value!r} given; allowed: panda_wristcam, panda")
    return str(value)


def _check_backend(value: Any, num_envs: int) -> None:
    word = str(value).split(":", 1)[0]
    if word in ("gpu", "cuda", "physx_cuda"):
        _warn_once(f"sim_backend {value}: engram computes on the CPU; tensors are on device cpu")
    elif word in ("cpu", "physx_cpu"):
        if num_envs > 1:  # the original refuses this, too
            raise InvalidArgumentError(
                f"sim_backend: {value!r} given with num_envs {num_envs}; the original's CPU "
                "backend has one environment; allowed: auto, gpu (both compute on the CPU here)"
            )
    elif word != "auto":
        raise InvalidArgumentError(f"sim_backend: {value!r} given; allowed: auto, cpu, gpu, cuda:N")


def _task_constants(own: Mapping[str, Any], steps: Mapping[str, str]) -> dict[str, Any]:
    """Constants from keywords of some tasks."""
    constants: dict[str, Any] = {}
    for name, constant in steps.items():
        if name in own:
            value = integer(name, own[name], 1)
            if constant:
                constants[constant] = value
    if "angle_threshold" in own:
        constants["angle_threshold"] = real("angle_threshold", own["angle_threshold"])
    if own.get("blink_color") is not None:
        raise InvalidArgumentError(
            f"blink_color: {own['blink_color']!r} given; the lamp has one colour; allowed: None"
        )
    return constants


def _size(what: str, configs: Any, cameras: tuple[str, ...], default: int) -> tuple[int, int]:
    """Width and height from configurations of cameras: of all, or by camera."""
    if not configs:
        return default, default
    if not isinstance(configs, Mapping):
        raise InvalidArgumentError(f"{what}: {configs!r} given, a dict needed")
    shared = {key: value for key, value in configs.items() if key not in cameras}
    sizes = set()
    for camera in cameras:
        one = {**shared, **configs.get(camera, {})}
        for key in one:
            if key not in _SIZES:
                raise InvalidArgumentError(
                    f"{what}: {key}={one[key]!r} given; of a camera only width and height can be "
                    f"chosen; cameras: {', '.join(cameras)}"
                )
        sizes.add(
            tuple(integer(f"{what}: {key}", one.get(key, default), 1, 4096) for key in _SIZES)
        )
    if len(sizes) > 1:
        raise InvalidArgumentError(
            f"{what}: {configs!r} given; all cameras have one size; give it without their names"
        )
    width, height = sizes.pop()
    return width, height


def _sensor_size(configs: Any) -> tuple[int, int]:
    return _size("sensor_configs", configs, ("base_camera", "hand_camera"), 128)


def _render_size(configs: Any) -> tuple[int, int]:
    return _size("human_render_camera_configs", configs, ("render_camera",), 512)


def drawn_seeds(seed: int, count: int) -> list[int]:
    """Seeds of a batch: the first is given, the others are drawn from it, the same for any count.

    Args:
        seed: From 0 to 2^64 - 1; others are left to who uses it.
        count: How many.
    """
    if not 0 <= seed < 2**64:
        return [seed] * count
    words = [seed & 0xFFFFFFFF, seed >> 32]
    others = np.random.RandomState(words).randint(0, 2**31, count - 1)
    return [seed, *map(int, others)]


def seeds(value: Any) -> Any:
    """A seed, or one per environment, as engram takes them."""
    if isinstance(value, torch.Tensor):
        value = value.cpu().numpy()
    if isinstance(value, np.ndarray):
        value = value.tolist()
    return list(value) if isinstance(value, tuple) else value
