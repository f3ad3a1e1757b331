"""What there is to choose: every id, with a picture and all that is known of it before it runs."""

from __future__ import annotations

import contextlib
from typing import Any

import engram
from engram.play import pictures
from engram.play.episode_spec import Setting

_SIZE = (320, 240)
_SEED = 4_242_424_242
_LOOK = 60  # control steps after which a picture is taken, at most


class Catalogue:
    """Descriptions and pictures of tasks, each made when it is first asked for."""

    def __init__(self) -> None:
        self._summaries: dict[str, Any] = {task["id"]: task for task in engram.list()}
        self._made: dict[str, tuple[dict[str, Any], bytes]] = {}

    def __contains__(self, id: str) -> bool:
        return id in self._summaries

    def list(self) -> list[dict[str, Any]]:
        """All tasks in short, in the registry's order."""
        return [{name: task[name] for name in _SUMMARY} for task in self._summaries.values()]

    def described(self, id: str) -> dict[str, Any]:
        """One of them in full."""
        return self._of(id)[0]

    def picture(self, id: str) -> bytes:
        """A JPEG file: the middle of an episode that the oracle plays."""
        return self._of(id)[1]

    def _of(self, id: str) -> tuple[dict[str, Any], bytes]:
        if id not in self._made:
            setting = Setting(id, _SEED)
            with contextlib.closing(setting.batch(obs_mode="state")) as env:
                setting.reset(env)
                for _ in range(min(env.description["horizon"] // 2, _LOOK)):
                    env.step(env.act("oracle"))
                picture = pictures.jpeg(env.frame(0, "render_camera", _SIZE), 80)
                description: Any = env.description
                self._made[id] = {name: description[name] for name in _DESCRIPTION}, picture
        return self._made[id]


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
