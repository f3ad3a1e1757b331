"""Registration of classes with Gymnasium, without a namespace, and their time limit."""

from __future__ import annotations

import functools
import json
import warnings
from collections.abc import Callable
from copy import copy
from typing import Any, TypeVar

import gymnasium as gym
from gymnasium.envs.registration import WrapperSpec

from engram._args.values import text
from engram.errors import InvalidArgumentError
from engram.gym_registration import register as register_variant
from engram.mikasa._base_wrappers import Wrapper
from engram.mikasa._variants import TaskMeta, changed_constants, own_instruction
from engram.mikasa.env import BaseEnv
from engram.mikasa.gym_utils import find_max_episode_steps_value

_Class = TypeVar("_Class", bound=type)

# Classes by id, for Gymnasium's entry points.
REGISTERED: dict[str, TaskMeta] = {}


class _Unseen(tuple[WrapperSpec, ...]):
    """Wrappers that gym.make applies. gym.make_vec would refuse ids that have any."""

    def __len__(self) -> int:
        return 0


class TimeLimitWrapper(Wrapper):
    """Truncates episodes, each environment's when it has had its steps.

    Gymnasium puts its own limit around an environment, which knows no batches; this one takes its
    place.

    Args:
        env: The environment, within Gymnasium's wrappers or not.
        max_episode_steps: The limit; None: that of Gymnasium's wrapper.
    """

    _passes_parts = True

    def __init__(self, env: gym.Env[Any, Any], max_episode_steps: int | None = None) -> None:
        steps = max_episode_steps or find_max_episode_steps_value(env)
        super().__init__(env.unwrapped if max_episode_steps is None else env)
        self._max_episode_steps = steps

    @property
    def spec(self) -> Any:  # type: ignore[override]
        """The specification that gym.make was given, with the limit."""
        spec = copy(self.env.unwrapped.spec)
        if spec is not None:
            spec.max_episode_steps = self._max_episode_steps
        return spec

    def step(self, action: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """See the environment; truncated where the limit is reached."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        limit = self._max_episode_steps
        base: Any = self.unwrapped
        if limit is not None and base._most_steps >= limit:
            elapsed = info["elapsed_steps"]
            base._most_steps = int(elapsed.max())
            truncated = truncated | (elapsed >= limit)
        return observation, reward, terminated, truncated, info


def register_env(
    uid: str,
    max_episode_steps: int | None = None,
    override: bool = False,
    asset_download_ids: Any = (),
    **kwargs: Any,
) -> Callable[[_Class], _Class]:
    """A decorator that registers a class of a task under an id.

    Args:
        uid: The id, for gym.make; if the class changes constants, the id is registered with
            engram, too.
        max_episode_steps: Control steps of an episode; None: no limit.
        override: True: a registered id is replaced; otherwise it is unchanged, with a warning.
        asset_download_ids: Has no effect: there is nothing to download.
        **kwargs: Defaults of gym.make's keywords; JSON must be able to hold them.

    Raises:
        InvalidArgumentError: The class is not one of a task, or overrides what cannot be.
    """
    text("uid", uid)
    try:
        json.dumps(kwargs)
    except (TypeError, ValueError):
        raise InvalidArgumentError(
            f"keywords of register_env: {kwargs!r} given, what JSON can hold needed"
        ) from None

    def decorate(cls: _Class) -> _Class:
        _register(uid, cls, max_episode_steps, override, kwargs)
        return cls

    return decorate


def _register(
    uid: str, cls: Any, max_episode_steps: int | None, override: bool, kwargs: dict[str, Any]
) -> None:
    if not (isinstance(cls, TaskMeta) and issubclass(cls, BaseEnv)):
        raise InvalidArgumentError(f"register_env: {cls!r} given, a subclass of BaseEnv needed")
    if not hasattr(cls, "_task"):
        raise InvalidArgumentError(
            f"register_env: {cls.__name__} derives from BaseEnv itself; engram has the tasks that "
            "engram.list() names: derive from the class of one of them"
        )
    if uid in REGISTERED and not override:
        warnings.warn(f"{uid} is registered already; override=True replaces it", stacklevel=4)
        return
    if not cls.__dict__.get("_generated", False):
        _register_variant(uid, cls, changed_constants(cls), max_episode_steps, override)
    REGISTERED[uid] = cls
    gym.registry.pop(uid, None)
    gym.register(
        id=uid,
        entry_point=functools.partial(make, uid),
        vector_entry_point=functools.partial(make_vec, uid),
        max_episode_steps=max_episode_steps,
        disable_env_checker=True,
        kwargs=dict(kwargs),
        additional_wrappers=_Unseen(
            [WrapperSpec("TimeLimitWrapper", f"{__name__}:TimeLimitWrapper", {})]
        ),
    )


def _register_variant(
    uid: str, cls: Any, constants: dict[str, Any], steps: int | None, override: bool
) -> None:
    """Registers a class with other constants as a variant of engram."""
    if steps is not None:
        constants = {**constants, "max_episode_steps": steps}
    instruction = own_instruction(cls)
    try:
        register_variant(uid, base=cls._task, constants=constants, instruction=instruction)
    except InvalidArgumentError:
        if not (override and uid in REGISTERED):
            raise


def make(uid: str, **kwargs: Any) -> BaseEnv:
    """The environment of an id, without a time limit."""
    env: BaseEnv = REGISTERED[uid](**kwargs)
    return env


def make_vec(uid: str, num_envs: int = 1, **kwargs: Any) -> Any:
    """A ManiSkillVectorEnv of an id."""
    from engram.mikasa.vector import ManiSkillVectorEnv

    return ManiSkillVectorEnv(gym.make(uid, num_envs=num_envs, **kwargs), num_envs)
