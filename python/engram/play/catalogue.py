"""Catalogue of all tasks, each with its description and a picture."""

from __future__ import annotations

import contextlib
from typing import Any

import engram
from engram.play import pictures
from engram.play.episode_spec import EpisodeSpec

_SIZE = (320, 240)
_SEED = 4_242_424_242
_MOST_STEPS = 60  # control steps before the picture


class Catalogue:
    """Descriptions and pictures of tasks, each computed on first use."""

    def __init__(self) -> None:
        self._summaries: dict[str, Any] = {task["id"]: task for task in engram.list()}
        self._cache: dict[str, tuple[dict[str, Any], bytes]] = {}

    def __contains__(self, id: str) -> bool:
        return id in self._summaries

    def list(self) -> list[dict[str, Any]]:
        """Summaries of all tasks, in the registry's order."""
        return [{name: task[name] for name in _SUMMARY} for task in self._summaries.values()]

    def described(self, id: str) -> dict[str, Any]:
        """The description of a task."""
        return self._computed(id)[0]

    def picture(self, id: str) -> bytes:
        """A JPEG file: the middle of an episode that the oracle plays."""
        return self._computed(id)[1]

    def _computed(self, id: str) -> tuple[dict[str, Any], bytes]:
        if id not in self._cache:
            spec = EpisodeSpec(id, _SEED)
            with contextlib.closing(spec.make_batch(obs_mode="state")) as env:
                spec.reset(env)
                for _ in range(min(env.description["horizon"] // 2, _MOST_STEPS)):
                    env.step(env.act("oracle"))
                picture = pictures.jpeg(env.frame(0, "render_camera", _SIZE), 80)
                description: Any = env.description
                self._cache[id] = {name: description[name] for name in _DESCRIPTION}, picture
        return self._cache[id]


_SUMMARY = ("id", "family", "split", "memory_type", "horizon", "canonical", "instruction")
_DESCRIPTION = (
    *_SUMMARY,
    "candidates",
    "chance",
    "answer",
    "answer_chance",
    "ceilings",
    "termination",
    "frozen_cue",
    "draws",
    "options",
    "changeable",
    "phases",
)
