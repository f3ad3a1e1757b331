"""The benchmark's evaluation protocol with a policy in Python."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from engram import _core
from engram._option_list import OBS_MODE, RULES
from engram._values import constants_json, one_of
from engram.errors import InvalidArgumentError

__all__ = ["evaluate"]

Policy = Callable[[dict[str, Any]], Any]


def evaluate(
    policy: Policy,
    ids: str | Iterable[str],
    *,
    episodes: int = 50,
    seed: int = 4242424242,
    num_envs: int = 8,
    threads: int = 0,
    obs: str = "rgb",
    renderer: str = "cpu",
    rules: str = "reference",
    task_options: Mapping[str, float] | None = None,
    constants: Mapping[str, Any] | None = None,
    name: str = "external",
    config: Mapping[str, Any] | None = None,
    output: str | os.PathLike[str] | None = None,
    resume: str | os.PathLike[str] | None = None,
    progress: Callable[[int, int, int], None] | None = None,
) -> dict[str, Any]:
    """Success rates of a policy: ``{"summary": ..., "tasks": [...]}``, as ``engram eval --json``.

    ``policy(observation)`` is called with the episodes that need actions, N of them:

    * ``rgb`` (N, 128, 128, 6) uint8, base camera before wrist camera; with ``obs="rgb"`` only
    * ``state`` (N, state_dim) float32: the row of ``obs="state"`` or ``obs="objects"``, which the
      results then say
    * ``proprio`` (N, 7) float32, ``instruction`` N strings, ``env_id``
    * ``episode``, ``step`` (N,): number of the episode, control steps in it so far
    * ``first`` (N,): 1 at the first request of an episode
    * ``worker`` and ``slot`` (N,): a place that the episode keeps from beginning to end

    The arrays are the policy's to keep. It returns an array of shape (N, 7) or (N, K, 7), or
    a sequence of N arrays of shape (7), (K, 7) or (1, K, 7): actions that are used one per step
    before the episode is asked for again. It is called from several threads, by one at a time;
    for one large batch, ``threads=1, num_envs=50``.

    ``rules`` ("reference" or "original"), ``task_options``, ``constants``: those of the
    environments.
    ``output``: results go to ``<output>/<split>/<date_time>/``. ``resume``: folder of an
    interrupted run with the same arguments. ``progress(episodes, all_episodes, env_steps)`` is
    called several times a second.
    """
    if obs not in ("rgb", "state", "objects"):
        raise InvalidArgumentError(f"obs: {obs!r} given, 'rgb', 'state' or 'objects' allowed")

    def act(observation: dict[str, Any]) -> list[np.ndarray]:
        return _chunks(policy(observation), len(observation["instruction"]))

    text = _core.evaluate(
        policy=act,
        ids=[ids] if isinstance(ids, str) else list(ids),
        episodes=episodes,
        seed=seed,
        num_envs=num_envs,
        threads=threads,
        obs_mode=OBS_MODE[obs],
        name=name,
        config=json.dumps(dict(config or {})),
        renderer=renderer,
        output=None if output is None else os.fspath(output),
        resume=None if resume is None else os.fspath(resume),
        rules=one_of("rules", rules, RULES),
        constants=constants_json(constants),
        task_options=[(option, float(value)) for option, value in (task_options or {}).items()],
        progress=progress,
    )
    return json.loads(text)


def _chunks(answer: Any, count: int) -> list[np.ndarray]:
    """The answer as one array per episode."""
    if not isinstance(answer, Sequence) or isinstance(answer, (str, bytes)):
        answer = np.asarray(answer)
    if len(answer) != count:
        raise InvalidArgumentError(f"policy: {len(answer)} rows given, {count} needed")
    return [np.ascontiguousarray(chunk, np.float32) for chunk in answer]
