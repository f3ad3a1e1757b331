"""Wrappers of rewards: a potential instead of the dense reward, the horizon's rest at success."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from engram.errors import InvalidArgumentError
from engram.wrappers.base import Step, Wrapper, horizons
from engram.wrappers.numbers import RANGE


class PotentialReward(Wrapper):
    """Pays progress instead of being near: what is gained is lost again by going back.

    With r_t the reward of the batch inside, x_j terms of the task's reward, and a potential of
    where the step has led to,

        phi_t  = weight clip(r_t, 0, 1) + sum of w_j g(x_j),
        r'_t   = gamma phi_t - phi_(t-1),    phi_0 = 0,

    where g(d) = max(0, 1 - d / 0.5 m) of a distance (a name that ends in "dist"), else
    g(x) = clip(x, 0, 1), and phi_t = 0 if the episode has failed. The discounted sum of T steps is
    gamma^T phi_T, whatever lies between: standing still before success pays nothing (Ng, Harada and
    Russell, 1999). Made for ``reward_mode="normalized_dense"``, in which a step with success has 1.

    Where a task has two stages, what the first one asks for can cost in the second: a cube that
    returns leaves the target. With a term x_k of 0 or 1 that tells that a stage is over,
    ``until={"j": "k"}`` lets g(x_j) count as 1 once x_k is 1, and ``since={"j": "k"}`` as 0 before.

    Args:
        env: A batch, which need not be privileged.
        gamma: Discount of the learner.
        weight: Of the dense reward.
        terms: Weights w_j by names of ``engram.describe(id)["reward_terms"]``; their values are
            those of the step before. Of several tasks, those that a task's reward has.
        until: Terms that are done, by those of the first stage.
        since: Terms that are done, by those of the second stage.
    """

    def __init__(
        self,
        env: Any,
        gamma: float = 0.99,
        weight: float = 1.0,
        terms: Mapping[str, float] | None = None,
        until: Mapping[str, str] | None = None,
        since: Mapping[str, str] | None = None,
    ) -> None:
        super().__init__(env)
        _check_gamma(gamma)
        if not weight >= 0:
            raise InvalidArgumentError(f"weight: {weight!r} given, 0 or more needed")
        self.gamma, self.weight = gamma, weight
        self.terms = {} if terms is None else dict(terms)
        tasks = [env.task_of(i)["reward_terms"] for i in range(self.num_envs)]
        # Read from the batch itself: the info is privileged, and policies are not to see it.
        batch = env.unwrapped
        has_terms = "reward_dict" in batch._views  # which tasks of users' own may not have
        self._now = batch._views["reward_dict"] if has_terms else np.zeros((self.num_envs, 0))
        self._last = None
        if has_terms and self._same_step:
            self._last = batch._batch.final_output("reward_dict")
        self._weights = np.zeros(self._now.shape)
        self._distances = np.zeros(self._now.shape, np.bool_)
        for name, value in self.terms.items():
            column = _columns("terms", tasks, name)
            which = np.flatnonzero(column >= 0)
            self._weights[which, column[which]] = value
            self._distances[which, column[which]] = name.endswith("dist")
        # Columns of the term and of the one that ends or begins its stage, per environment.
        stages = [("until", until or {}, 1.0), ("since", since or {}, 0.0)]
        self._stages = [
            (_columns(key, tasks, name), _columns(key, tasks, done), there)
            for key, pairs, there in stages
            for name, done in pairs.items()
        ]
        self._potential = np.zeros(self.num_envs)

    def reward(self, step: Step) -> np.ndarray:
        step.keep_benchmark_reward()
        potential = self.weight * np.clip(step.reward, 0, 1).astype(np.float64)
        if self.terms:
            potential += (self._shaped(step) * self._weights).sum(1)
        failed = step.terminated & ~step.value("success")
        potential[failed | step.idle] = 0
        reward = self.gamma * potential - self._potential
        reward[step.idle] = 0
        self._potential = potential
        return reward.astype(np.float32)

    def _shaped(self, step: Step) -> np.ndarray:
        """G of each term, (N, terms); 0 where there is none yet."""
        values = self._now
        if self._last is not None:
            values = np.where(step.ended[:, None], self._last, values)
        shaped: np.ndarray = np.clip(np.where(self._distances, 1 - values / RANGE, values), 0, 1)
        shaped = np.nan_to_num(shaped)
        rows = np.arange(self.num_envs)
        for term, done, there in self._stages:
            over = np.nan_to_num(values[rows, done]) > 0.5
            has = (term >= 0) & (done >= 0) & (over if there else ~over)
            shaped[rows[has], term[has]] = there
        return shaped

    def begin(self, began: np.ndarray) -> None:
        self._potential[began] = 0


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


def _columns(key: str, tasks: list[Sequence[str]], name: str) -> np.ndarray:
    """Index of a term in each task's reward, -1 where it has none."""
    columns = np.array([_index(terms, name) for terms in tasks])
    if (columns < 0).all():
        allowed = ", ".join(sorted({term for terms in tasks for term in terms}))
        raise InvalidArgumentError(f"{key}: {name!r} given; allowed: {allowed}")
    return columns


def _index(names: Sequence[str], name: str) -> int:
    return names.index(name) if name in names else -1


def _check_gamma(gamma: float) -> None:
    if not 0 < gamma <= 1:
        raise InvalidArgumentError(f"gamma: {gamma!r} given, more than 0, up to 1 needed")
