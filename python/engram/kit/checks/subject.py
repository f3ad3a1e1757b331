"""The task under check: its description, and batches of it."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import re
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from engram import _core
from engram.factory import make_vec
from engram.kit.checks.report import Finding, Verdict
from engram.kit.registration import definitions
from engram.kit.task import Task
from engram.tasks import describe

_DEFAULT_FLOOR = 0.95
# Constants that every task has; engram's own tests hold them.
COMMON = ("robot_uids", "max_episode_steps", "robot_init_qpos_noise")


@dataclasses.dataclass(frozen=True)
class Settings:
    """What is checked, and how thoroughly."""

    id: str
    file: Path | None = None  # if it comes from one
    episodes: int = 64  # of success rates
    fast: bool = False
    hidden: str = ""  # a draw; empty: the one that the task names


class Subject:
    """A task, and what is asked about it."""

    def __init__(self, settings: Settings, findings: list[Finding], tasks: list[Task]) -> None:
        self.id = settings.id
        self.file = settings.file
        self.episodes = settings.episodes
        self.fast = settings.fast
        self.findings = findings
        self.tasks = tasks  # instances that the engine has made, the latest at the end
        self.description: Any = describe(self.id)
        self.hidden = settings.hidden or self.description["hidden"]
        self.floor = _DEFAULT_FLOOR
        self.declared: dict[str, dict[str, Any]] = {}  # draws
        self.scripts: tuple[str, ...] = ("oracle", "blind", "sweep")
        if self.is_own:
            self.floor = json.loads(definitions[self.id][0])["oracle_floor"]
            about = json.loads(self.tasks[-1].describe())
            self.declared = {draw["name"]: draw for draw in about["draws"]}
            self.scripts = tuple(name for name in self.scripts if name in about["methods"])

    @property
    def is_own(self) -> bool:
        """Whether it is written with engram.Task."""
        return self.id in definitions

    @property
    def horizon(self) -> int:
        return int(self.description["horizon"])

    @property
    def policy(self) -> str:
        """What moves the robot where any script does."""
        return "oracle" if "oracle" in self.scripts else "random"

    def add(self, check: str, verdict: Verdict, sentence: str, **figures: Any) -> None:
        self.findings.append(Finding(self.id, check, verdict, sentence, figures))

    @contextlib.contextmanager
    def batch(self, num_envs: int, **options: Any) -> Iterator[Any]:
        """A batch that stands still where episodes have ended."""
        defaults = {
            "autoreset_mode": "DISABLED",
            "after_end": "hold",
            "privileged": True,
            "threads": 1,
        }
        options = {**defaults, **options}
        env = make_vec(self.id, num_envs, **options)
        try:
            yield env
        finally:
            env.close()

    def view(self, column: str) -> Any:
        """A copy of a column of the latest batch, of tasks of one's own only."""
        return np.array(self.tasks[-1].__dict__["_whole"].get(column, np.zeros(1)))

    @property
    def prop_names(self) -> list[str]:
        return [prop["name"] for prop in self.description["props"]]

    # --- phases ---

    def start_of_last_phase(self, drawn: dict[str, Any], count: int) -> Any:
        """The step in which the last phase begins (count,); None if its condition is in words."""
        phases = self.description["phases"]
        found = re.fullmatch(r"elapsed >= ([\w +]+)", phases[-1]["when"]) if phases else None
        return None if found is None else _total(found[1], drawn, count)

    def cue_end(self, drawn: dict[str, Any], count: int) -> Any:
        """The step from which on nothing may show what is hidden (count,), or None."""
        if self.is_own:
            return self.view("cue_end")
        for phase in self.description["phases"]:
            found = re.fullmatch(r"elapsed < ([\w +]+)", phase["when"])
            if phase["name"] == "cue" and found is not None:
                return _total(found[1], drawn, count)
        return self.start_of_last_phase(drawn, count)


def _total(words: str, drawn: dict[str, Any], count: int) -> Any:
    """The sum of draws and numbers that a condition names."""
    total = np.zeros(count, np.int64)
    for word in words.split("+"):
        name = word.strip()
        if name.isdigit():
            total += int(name)
            continue
        value = drawn.get(name, drawn.get(f"{name}_per_env"))
        if value is None:
            return None
        total += value
    return total


@contextlib.contextmanager
def watched(id: str) -> Iterator[list[Task]]:
    """Collects the instances that the engine makes of a task of one's own."""
    found: list[Task] = []
    if id not in definitions:
        yield found
        return
    text, factory = definitions[id]
    _core.register_task(text, _watching(factory, found))
    try:
        found.append(factory(id, "{}"))
        yield found
    finally:
        _core.register_task(text, factory)


def _watching(factory: Callable[[str, str], Task], found: list[Task]) -> Callable[..., Task]:
    def make(id: str, constants: str) -> Task:
        task = factory(id, constants)
        bind = task.bind

        def bind_and_keep(*arrays: Any) -> None:
            bind(*arrays)
            found.append(task)

        def timed_call(*arguments: Any) -> None:
            begin = time.perf_counter()
            call(*arguments)
            task.__dict__["seconds"] += time.perf_counter() - begin

        call = task.call
        # Descriptions are never bound.
        task.__dict__.update(bind=bind_and_keep, call=timed_call, seconds=0.0)
        return task

    return make
