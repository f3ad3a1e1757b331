"""Catalogue of all tasks, each with its description and a picture."""

from __future__ import annotations

import contextlib
from typing import Any

import engram
from engram.kit.registration import definitions
from engram.play import pictures
from engram.play.episode_spec import EpisodeSpec
from engram.play.score import rate_of

_SIZE = (320, 240)
_SEED = 4_242_424_242
_MOST_STEPS = 60  # control steps before the picture


class Catalogue:
    """Descriptions and pictures of tasks, each computed on first use."""

    def __init__(self) -> None:
        self._ids = [task["id"] for task in engram.list()]
        self._known = set(self._ids)
        self._descriptions: dict[str, dict[str, Any]] = {}
        self._pictures: dict[str, bytes] = {}

    def __contains__(self, id: str) -> bool:
        return id in self._known

    def list(self) -> list[dict[str, Any]]:
        """Summaries of all tasks, in the registry's order."""
        return [{**_summary(self.described(id)), "own": id in definitions} for id in self._ids]

    def described(self, id: str) -> dict[str, Any]:
        """The description of a task."""
        if id not in self._descriptions:
            description: Any = engram.describe(id)
            self._descriptions[id] = {name: description[name] for name in _DESCRIPTION}
        return self._descriptions[id]

    def picture(self, id: str) -> bytes:
        """A JPEG file: the middle of an episode that the oracle plays."""
        if id not in self._pictures:
            spec = EpisodeSpec(id, _SEED)
            with contextlib.closing(spec.make_batch(obs_mode="state")) as env:
                spec.reset(env)
                for _ in range(min(env.description["horizon"] // 2, _MOST_STEPS)):
                    env.step(env.act("oracle"))
                self._pictures[id] = pictures.jpeg(env.frame(0, "render_camera", _SIZE), 80)
        return self._pictures[id]


def _summary(description: dict[str, Any]) -> dict[str, Any]:
    return {
        **{name: description[name] for name in _SUMMARY},
        "chance": description["chance"],
        **{policy: rate_of(description, policy) for policy in ("sweep", "oracle")},
        "phases": [phase["name"] for phase in description["phases"]],
    }


_SUMMARY = ("id", "family", "split", "memory_type", "horizon", "canonical", "instruction")
_DESCRIPTION = (
    *_SUMMARY,
    "candidates",
    "chance",
    "answer",
    "answer_chance",
    "choices",
    "ceilings",
    "termination",
    "frozen_cue",
    "draws",
    "options",
    "changeable",
    "phases",
)
