"""Wrappers of rewards: a potential instead of the dense reward, the horizon's rest at success."""

from __future__ import annotations

from typing import Any

import numpy as np

from engram.errors import InvalidArgumentError
from engram.wrappers.base import Step, Wrapper, horizons

# Distance from which on the hand's way to its object counts, m.
RANGE = 1.0


class PotentialReward(Wrapper):
    """Pays progress instead of being near: what is gained is lost again by going back.

    With r_t the reward of the batch inside, d_t the distance from the hand to where it has to be
    first, and a potential of where the step has led to,

        phi_t  = weight clip(r_t, 0, 1)^power + reach max(0, 1 - d_t / 1 m),
        r'_t   = gamma phi_t - phi_(t-1),    phi_0 = 0,

    where phi_t = 0 if the episode has failed. The discounted sum of T steps is gamma^T phi_T,
    whatever lies between: standing still before success pays nothing (Ng, Harada and Russell,
    1999). Made for ``reward_mode="normalized_dense"``, in which a step with success has 1.

    Args:
        env: A batch.
        gamma: Discount of the learner.
        weight: Of the dense reward.
        power: Of the dense reward; less than 1 makes its small values count more.
        reach: Weight of the distance.
        distance: The term of "reward_dict" that is the distance, which is one step old;
            ``engram.describe(id)["reward_terms"]`` has the names. The batch need not be privileged.
    """

    def __init__(
        self,
        env: Any,
        gamma: float = 0.99,
        weight: float = 1.0,
        power: float = 1.0,
        reach: float = 0.0,
        distance: str | None = None,
    ) -> None:
        super().__init__(env)
        _check_gamma(gamma)
        for name, value in (("weight", weight), ("power", power), ("reach", reach)):
            if not (value > 0 or (value == 0 and name != "power")):
                raise InvalidArgumentError(f"{name}: {value!r} given, 0 or more needed")
        self.gamma, self.weight, self.power, self.reach = gamma, weight, power, reach
        self._term = None if distance is None else _term(env, distance)
        # Read from the batch itself: the info is privileged, and policies are not to see it.
        batch = env.unwrapped
        self._terms = batch._views.get("reward_dict")
        self._final_terms = batch._batch.final_output("reward_dict") if self._same_step else None
        self._potential = np.zeros(self.num_envs)

    def reward(self, step: Step) -> np.ndarray:
        step.keep_benchmark_reward()
        potential = self.weight * np.clip(step.reward, 0, 1).astype(np.float64) ** self.power
        if self._term is not None:
            potential += self.reach * self._nearness(step)
        failed = step.terminated & ~step.value("success")
        potential[failed | step.idle] = 0
        reward = self.gamma * potential - self._potential
        reward[step.idle] = 0
        self._potential = potential
        return reward.astype(np.float32)

    def _nearness(self, step: Step) -> np.ndarray:
        """1 at the hand's goal, 0 from RANGE on."""
        distance = self._terms[:, self._term]
        if self._final_terms is not None:
            distance = np.where(step.ended, self._final_terms[:, self._term], distance)
        near: np.ndarray = np.maximum(1 - np.nan_to_num(distance, nan=RANGE) / RANGE, 0)
        return near

    def begin(self, began: np.ndarray) -> None:
        self._potential[began] = 0


def _term(env: Any, distance: str) -> int:
    terms = env.description["reward_terms"]
    if distance not in terms:
        raise InvalidArgumentError(f"distance: {distance!r} given; allowed: {', '.join(terms)}")
    return int(terms.index(distance))


class HeldReward(Wrapper):
    """Pays the rest of the horizon at the first success, so that an early end loses no return.

    In the step t of the first success, of a horizon of H steps,

        r'_t = r_t + bonus (1 + gamma + ... + gamma^(H-t)).

    Later steps of the episode, if it goes on, pay 0. Before, r' = r. The discounted value of the
    bonus falls with t: success as early as possible pays most.

    Args:
        env: A batch.
        gamma: Discount of the learner.
        bonus: For each step that is left.
    """

    def __init__(self, env: Any, gamma: float = 0.99, bonus: float = 1.0) -> None:
        super().__init__(env)
        _check_gamma(gamma)
        if not bonus >= 0:
            raise InvalidArgumentError(f"bonus: {bonus!r} given, 0 or more needed")
        self.gamma, self.bonus = gamma, bonus
        self._horizons = horizons(env)
        self._succeeded = np.zeros(self.num_envs, np.bool_)

    def reward(self, step: Step) -> np.ndarray:
        step.keep_benchmark_reward()
        first = step.value("success_once") & ~self._succeeded & ~step.idle
        left = np.maximum(self._horizons - step.value("elapsed_steps"), 0) + 1
        sums = left if self.gamma == 1 else (1 - self.gamma**left) / (1 - self.gamma)
        reward = np.where(self._succeeded | step.idle, 0, step.reward + first * self.bonus * sums)
        self._succeeded |= first
        return reward.astype(np.float32)

    def begin(self, began: np.ndarray) -> None:
        self._succeeded &= ~began


def _check_gamma(gamma: float) -> None:
    if not 0 < gamma <= 1:
        raise InvalidArgumentError(f"gamma: {gamma!r} given, more than 0, up to 1 needed")
