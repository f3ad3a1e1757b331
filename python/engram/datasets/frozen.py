"""Steps of demonstrations whose actions were not executed: the frozen cue (docs/evaluation.md)."""

from __future__ import annotations

import contextlib
import json
import threading
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from engram.datasets.episodes import Episode

COLUMN = "is_action_frozen"
_NOTE = (
    "**The first actions were not executed**: until the cue is over the environment replaced them "
    "by zeros, so that the gripper half closes (joint targets: by the measured ones), whatever "
    "`{}` says. `{}` marks these steps; leave them out of a loss on actions."
)
_LENGTHS = ("cue_steps_per_env", "empty_steps_per_env")  # of phases, as drawn


class FrozenCue:
    """Tells which actions of a task's episodes were replaced, and how long they may be.

    Args:
        env_id: The task.
        origin: How the episodes were made, as in their metadata; {} for those of the original
            benchmark, whose draws are not engram's. Of a task that cannot be made nothing is told.

    Attributes:
        horizon: Control steps after which an episode is truncated; None where it is not known.
    """

    def __init__(self, env_id: str, origin: Mapping[str, Any]) -> None:
        self._env: Any = None
        self.horizon: int | None = None
        self._lock = threading.Lock()
        if origin:
            self._open(env_id, origin)

    def _open(self, env_id: str, origin: Mapping[str, Any]) -> None:
        import engram  # the compiled part
        from engram.tasks import describe

        variant = origin.get("variant")
        options: dict[str, Any] = {"rules": origin.get("rules", "reference")}
        if isinstance(variant, Mapping):
            options["constants"] = variant.get("constants")
        if origin.get("perturbations"):
            options["perturb"] = origin["perturbations"]
        try:
            description = describe(env_id, **options)
            self.horizon = description["horizon"]
            if description["frozen_cue"]:
                self._env = engram.make(env_id, **options)
        except engram.Error:  # a task that is registered elsewhere, or a damaged origin
            return

    def __bool__(self) -> bool:
        return self._env is not None

    def mask(self, episode: Episode) -> np.ndarray:
        """Per step: whether the action was replaced. Threads may call it."""
        with self._lock:
            self._env.reset(seed=episode.episode_seed)
            drawn = self._env.drawn()
        first = sum(int(np.asarray(drawn[name]).item()) for name in _LENGTHS if name in drawn)
        return np.arange(len(episode)) < first

    def close(self) -> None:
        if self._env is not None:
            self._env.close()


def notes(is_frozen: bool, action: str, column: str = COLUMN) -> list[str]:
    """What a card says of it; action, column: names in the format."""
    return [_NOTE.format(action, column)] if is_frozen else []


def origin_of_words(words: Sequence[str]) -> dict[str, Any]:
    """What options of `engram collect` say of the rules, constants and perturbations."""
    origin: dict[str, Any] = {"rules": "reference"}
    constants: dict[str, Any] = {}
    levels: dict[str, float] = {}
    for name, value in _options(words):
        key, _, text = value.partition("=")
        if name == "--rules":
            origin["rules"] = value
        elif name == "--set":
            constants[key] = _constant(text)
        elif name == "--perturb":
            levels[key] = float(text)
    if constants:
        origin["variant"] = {"constants": constants}
    return origin | ({"perturbations": levels} if levels else {})


def _options(words: Sequence[str]) -> list[tuple[str, str]]:
    """Options and their values, given as one word or as two."""
    found = []
    for word, following in zip(words, [*words[1:], ""]):
        name, equals, value = word.partition("=")
        found.append((name, value if equals else following))
    return found


def _constant(text: str) -> Any:
    for one in (text, f"[{text}]"):
        with contextlib.suppress(ValueError):
            return json.loads(one)
    return text
