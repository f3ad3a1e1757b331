"""What all wrappers share: delegation, the ends of episodes, infos."""

from __future__ import annotations

from typing import Any

import numpy as np

from engram.envs.compat import GYMNASIUM_1, AutoresetMode, VectorBase
from engram.errors import BadStateError, InvalidArgumentError

# Info with the reward of the batch itself, beside a wrapper's.
BENCHMARK_REWARD = "benchmark_reward"


class Wrapper(VectorBase[Any]):
    """A batch whose actions, observations or rewards are transformed; changes nothing by itself.

    Other attributes and methods are those of the batch inside. Bits and results of its episodes
    are the batch's own: a wrapper only reads what a step returns, and adds to the infos.

    Args:
        env: A batch, or another wrapper of one.
    """

    # Name of the part of a dict that observations of this wrapper are; None: all.
    _key: str | None = None

    def __init__(self, env: Any) -> None:
        if not hasattr(env, "description"):
            raise InvalidArgumentError(f"env: {type(env).__name__} given, a batch of engram needed")
        self.env = env
        self.num_envs: int = env.num_envs
        for name in _SPACES:
            setattr(self, name, getattr(env, name))
        self.metadata = env.metadata
        self.render_mode = env.render_mode
        self.spec = env.spec
        self.is_vector_env = True
        self._same_step = env.autoreset_mode is AutoresetMode.SAME_STEP
        self._next_step = env.autoreset_mode is AutoresetMode.NEXT_STEP
        self._over = np.zeros(self.num_envs, np.bool_)  # ended, and not yet begun again
        self._has_own_finals = type(self).final_observation is not Wrapper.final_observation

    # --- what a wrapper transforms ---

    def action(self, actions: np.ndarray) -> np.ndarray:
        """The action for the batch inside."""
        return actions

    def observation(self, rows: Any, info: dict[str, Any], began: np.ndarray) -> Any:
        """The observation; `began` is True where it is an episode's first."""
        return rows

    def final_observation(self, rows: Any, info: Any, ended: np.ndarray) -> Any:
        """The last observations of the episodes that have ended, one row for each."""
        return rows

    def reward(self, step: Step) -> np.ndarray:
        """The reward of a step."""
        return step.reward

    def begin(self, began: np.ndarray) -> None:
        """Forgets what was kept of episodes, where new ones begin."""

    # --- running ---

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> Any:
        """Starts new episodes; see ``VectorEnv.reset``."""
        rows, info = self.env.reset(seed=seed, options=options)
        mask = (options or {}).get("reset_mask")
        began = np.ones(self.num_envs, np.bool_) if mask is None else np.array(mask, np.bool_)
        self._over &= ~began
        self.begin(began)
        return self.observation(rows, info, began), info

    def step(self, actions: Any) -> Any:
        """One control step; see ``VectorEnv.step``."""
        return self._outputs(*self.env.step(self._inner(actions)))

    def step_async(self, actions: Any) -> None:
        """Begins a step."""
        self.env.step_async(self._inner(actions))

    def step_wait(self, **_: Any) -> Any:
        """Waits for the step that ``step_async`` began; returns what ``step`` returns."""
        return self._outputs(*self.env.step_wait())

    def _inner(self, actions: Any) -> np.ndarray:
        actions = np.asarray(actions, np.float32)
        shape = self.action_space.shape
        if actions.shape != shape:
            raise InvalidArgumentError(f"actions: shape {actions.shape} given, {shape} needed")
        return self.action(actions)

    def _outputs(
        self, rows: Any, reward: Any, terminated: Any, truncated: Any, info: dict[str, Any]
    ) -> Any:
        ended = terminated | truncated
        step = Step(reward, terminated, truncated, info, self._over, self._same_step)
        reward = self.reward(step)
        began = ended if self._same_step else (self._over & self._next_step)
        if self._same_step and self._has_own_finals and ended.any():
            info = self._with_finals(info, ended)
        self.begin(began)
        rows = self.observation(rows, info, began)
        if self._next_step:
            self._over = np.array(ended)
        elif not self._same_step:
            self._over = self._over | ended
        return rows, reward, terminated, truncated, info

    def _with_finals(self, info: dict[str, Any], ended: np.ndarray) -> dict[str, Any]:
        """The infos with this wrapper's last observations."""
        indices = np.flatnonzero(ended)
        old, key = info["final_obs"][indices], self._key
        if key is None and isinstance(old[0], dict):
            return info
        rows = np.stack([one if key is None else one[key] for one in old])
        rows = self.final_observation(rows, info["final_info"], ended)
        finals = np.full(self.num_envs, None, dtype=object)
        for i, one, row in zip(indices, old, rows):
            finals[i] = row if key is None else {**one, key: row}
        names = ("final_obs",) if GYMNASIUM_1 else ("final_obs", "final_observation")
        return {**info, **dict.fromkeys(names, finals)}

    # --- the batch inside ---

    @property
    def unwrapped(self) -> Any:
        """The batch without wrappers."""
        return self.env.unwrapped

    @property
    def fields(self) -> list[dict[str, Any]]:
        """Name, offset, width and unit of each part of an observation row."""
        return fields_of(self.env)

    def restore(self, data: bytes, index: int | None = None) -> Any:
        """Refused: a snapshot does not have what wrappers keep of an episode."""
        raise BadStateError("restore: called on a wrapper; restore its batch, env.unwrapped")

    def render(self) -> Any:
        """One image per environment."""
        return self.env.render()

    def close(self, **_: Any) -> None:
        """Ends the batch."""
        self.env.close()

    @property
    def closed(self) -> bool:  # type: ignore[override]
        """Whether the batch is closed."""
        return bool(self.env.closed)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name == "env":
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        return getattr(self.env, name)

    def __len__(self) -> int:
        return self.num_envs

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {self.env!r}>"

    __str__ = __repr__

    def __del__(self) -> None:
        """Nothing: the batch inside closes itself."""


_SPACES = ("single_observation_space", "observation_space", "single_action_space", "action_space")


class Step:
    """What a step of the batch inside returned, as wrappers of rewards read it.

    Attributes:
        reward, terminated, truncated, info: As ``step`` returns them.
        ended: terminated or truncated.
        idle: True where no step was taken: the episode had ended before, and in the mode
            NEXT_STEP a new one has begun.
    """

    def __init__(
        self,
        reward: np.ndarray,
        terminated: np.ndarray,
        truncated: np.ndarray,
        info: dict[str, Any],
        idle: np.ndarray,
        same_step: bool,
    ) -> None:
        self.reward, self.terminated, self.truncated, self.info = (
            reward,
            terminated,
            truncated,
            info,
        )
        self.ended = terminated | truncated
        self.idle = idle
        self._same_step = same_step

    def value(self, name: str) -> np.ndarray:
        """An info of the step itself, of the episodes that it has ended too."""
        now = self.info[name]
        if not (self._same_step and self.ended.any()):
            return now
        last = self.info["final_info"]
        if GYMNASIUM_1:
            return np.where(self.ended, last[name], now)
        result = np.array(now)
        for i in np.flatnonzero(self.ended):
            result[i] = last[i][name]
        return result

    def keep_benchmark_reward(self) -> None:
        """Leaves the batch's own reward in the infos, unless an inner wrapper has."""
        if BENCHMARK_REWARD not in self.info:
            self.info[BENCHMARK_REWARD] = self.reward
            self.info[f"_{BENCHMARK_REWARD}"] = ~self.idle


def fields_of(env: Any) -> list[dict[str, Any]]:
    """Parts of the observation rows of a batch or a wrapper."""
    return list(env.fields if isinstance(env, Wrapper) else env.description["state_fields"])


def horizons(env: Any) -> np.ndarray:
    """Control steps of an episode of each environment."""
    return np.array([env.task_of(i)["horizon"] for i in range(env.num_envs)], np.int64)
