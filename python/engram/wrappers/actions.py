"""Wrappers of actions: their scale, and smoothing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.spaces import Box
from gymnasium.vector.utils import batch_space

from engram.errors import InvalidArgumentError
from engram.wrappers.base import Wrapper


class ScaleActions(Wrapper):
    """Multiplies actions: a Gaussian policy of deviation 1 moves the arm by a share of its limits.

    The batch inside gets clip(scale a, low, high); actions range from low / scale to high / scale.

    Args:
        env: A batch.
        scale: For each component of an action, or one for all; more than 0.
    """

    def __init__(self, env: Any, scale: float | Sequence[float] = 1.0) -> None:
        super().__init__(env)
        inner = env.single_action_space
        self.scale = np.asarray(scale, np.float32)
        if self.scale.shape not in ((), inner.shape) or not (self.scale > 0).all():
            raise InvalidArgumentError(
                f"scale: {scale!r} given, a number or {inner.shape[0]} of them above 0 needed"
            )
        self._low, self._high = inner.low, inner.high
        self.single_action_space = Box(
            inner.low / self.scale, inner.high / self.scale, dtype=np.float32
        )
        self.action_space = batch_space(self.single_action_space, self.num_envs)

    def action(self, actions: np.ndarray) -> np.ndarray:
        return np.clip(actions * self.scale, self._low, self._high)

    def act(self, policy: Any = "oracle") -> np.ndarray:
        """Actions of a scripted policy, as ``step`` takes them."""
        actions: np.ndarray = self.env.act(policy) / self.scale
        return actions


class SmoothActions(Wrapper):
    """Averages actions over time: exploration moves the arm less to and fro.

    The batch inside gets b_t = (1 - smoothing) a_t + smoothing b_(t-1), with b = 0 before an
    episode's first action.

    Args:
        env: A batch.
        smoothing: Weight of the past, 0 (none) to less than 1.
    """

    def __init__(self, env: Any, smoothing: float = 0.5) -> None:
        super().__init__(env)
        if not 0 <= smoothing < 1:
            raise InvalidArgumentError(f"smoothing: {smoothing!r} given, 0 to less than 1 allowed")
        self.smoothing = smoothing
        self._past: np.ndarray = np.zeros(
            (self.num_envs, env.single_action_space.shape[0]), np.float32
        )

    def action(self, actions: np.ndarray) -> np.ndarray:
        self._past = (1 - self.smoothing) * actions + self.smoothing * self._past
        return self._past

    def begin(self, began: np.ndarray) -> None:
        if began.any():
            self._past = np.where(began[:, None], np.float32(0), self._past)

    def act(self, policy: Any = "oracle") -> np.ndarray:
        """Actions of which the smoothed ones are a scripted policy's; they can exceed the space."""
        wanted = self.env.act(policy)
        actions: np.ndarray = (wanted - self.smoothing * self._past) / (1 - self.smoothing)
        return actions
