"""Policies and folders to watch, from the command line only, never from the page."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import engram
from engram.datasets import DemonstrationFolder, checks, find_folders
from engram.datasets.checks import DatasetError
from engram.play.episode_spec import EpisodeSpec
from engram.play.playback import Playback, Policy, recorded_policy
from engram.play.policy_process import PolicyProcess

BUILTIN = ("oracle", "sweep", "blind", "random", "zero")
PROCESS = "process"
_SETTINGS = "settings.json"
_LARGEST_RESULT = 64 << 20  # bytes
_MOST_EPISODES = 100_000


class SourceError(Exception):
    """A folder of the command line cannot be used; the message gives the reason."""


def builtin_policy(policy: str) -> Policy:
    """One of engram's own policies."""

    def act(env: Any, _first: bool) -> npt.NDArray[np.float32]:
        actions: npt.NDArray[np.float32] = env.act(policy)
        return np.clip(actions, -1, 1)

    return act


class Sources:
    """Policies by name and folders by number, for the page to choose from."""

    def __init__(
        self, folders: list[Path], command: str | None, obs: str, timeout: float, slots: int
    ) -> None:
        self._folders = [_folder(path) for path in folders]
        self._command = command
        self._obs = obs
        self._timeout = timeout
        self._slots = slots
        self._process: PolicyProcess | None = None

    def message(self) -> dict[str, Any]:
        """The choices, for the page."""
        names = [*BUILTIN, *([PROCESS] if self._command is not None else [])]
        return {"sources": names, "folders": [folder.message() for folder in self._folders]}

    def policy(self, name: str) -> tuple[Policy, str]:
        """The policy of that name, and the observation mode that it needs."""
        if name == PROCESS and self._command is not None:
            if self._process is None:
                self._process = PolicyProcess(self._command, self._obs, self._slots, self._timeout)
            return self._process.act, self._obs
        if name not in BUILTIN:
            raise SourceError(
                f"no policy '{name}'; there are: {', '.join(self.message()['sources'])}"
            )
        return builtin_policy(name), "state"

    def stop_process(self) -> None:
        """Ends the policy's process; the next request starts a new one."""
        if self._process is not None:
            self._process.close()
            self._process = None

    def stored(self, folder: int, task: int, episode: int) -> Playback:
        """An episode of a folder."""
        if folder >= len(self._folders):
            raise SourceError(f"no folder {folder}; there are {len(self._folders)}")
        return self._folders[folder].playback(task, episode, self.policy)

    def close(self) -> None:
        self.stop_process()


class _Demonstrations:
    """Demonstrations, of `engram collect` or of this page."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._data_sets: list[DemonstrationFolder] = find_folders(path)

    def message(self) -> dict[str, Any]:
        tasks = [
            {
                "id": folder.env_id,
                "episodes": [
                    {"seed": str(seed), "steps": steps, "success": True}
                    for seed, steps in zip(
                        folder.metadata["episode_seeds"], folder.metadata["episode_lengths"]
                    )
                ][:_MOST_EPISODES],
            }
            for folder in self._data_sets
        ]
        return {"name": self._path.name, "kind": "demonstrations", "tasks": tasks}

    def playback(self, task: int, episode: int, _policy: Any) -> Playback:
        folder = _at(self._data_sets, task, "data set")
        stored = folder[_index(folder, episode, "episode")]
        rules = folder.metadata.get("engram", {}).get("rules", "reference")
        return Playback(
            EpisodeSpec(folder.env_id, stored.episode_seed, rules=str(rules)),
            recorded_policy(list(stored.action)),
            most_steps=len(stored),
        )


class _Results:
    """Results of `engram eval`. They have no actions; the policy acts again."""

    def __init__(self, path: Path) -> None:
        self._path = path
        settings = _document(path / _SETTINGS)
        self._policy = str(settings.get("policy"))
        self._rules = str(settings.get("rules", "reference"))
        self._options = _table(path, settings, "task_options")
        self._constants = _table(path, settings, "constants")
        _register(path, settings)
        self._tasks = []
        ids = settings.get("tasks")
        for id in ids if isinstance(ids, list) else []:
            file = path / f"{checks.env_id('tasks', id)}.json"
            if file.is_file():
                self._tasks.append((id, _episodes(file)))
        if not self._tasks:
            raise SourceError(f"'{path}' holds no results of a finished task")

    def message(self) -> dict[str, Any]:
        tasks = [{"id": id, "episodes": episodes} for id, episodes in self._tasks]
        return {
            "name": self._path.name,
            "kind": "results",
            "policy": self._policy[:100],
            "tasks": tasks,
        }

    def playback(
        self, task: int, episode: int, policy: Callable[[str], tuple[Policy, str]]
    ) -> Playback:
        id, episodes = _at(self._tasks, task, "task")
        seed = int(_at(episodes, episode, "episode")["seed"])
        own = self._policy in BUILTIN
        try:
            actor, obs = policy(self._policy if own else PROCESS)
        except SourceError:
            raise SourceError(
                f"the policy '{self._policy}' has to be given again: --policy-command"
            ) from None
        spec = EpisodeSpec(
            id, seed, constants=self._constants, options=self._options, rules=self._rules
        )
        return Playback(spec, actor, obs_mode=obs)


def _folder(path: Path) -> _Demonstrations | _Results:
    try:
        if (path / "data_npz").is_dir():
            return _Demonstrations(path)
        if (path / _SETTINGS).is_file():
            return _Results(path)
    except DatasetError as error:
        raise SourceError(str(error)) from error
    raise SourceError(
        f"--folder: '{path}' given; a folder with data_npz (of `engram collect`) or settings.json "
        "(results of `engram eval`) needed"
    )


def _table(path: Path, settings: dict[str, Any], name: str) -> dict[str, Any]:
    """Names and values of settings.json; the simulator checks their meaning."""
    table = settings.get(name) or {}
    if not isinstance(table, dict):
        raise SourceError(f"'{path / _SETTINGS}': {name}: an object needed")
    return table


def _register(path: Path, settings: dict[str, Any]) -> None:
    """Registers the evaluated variants; equal ones may repeat."""
    variants = settings.get("variants") or []
    for one in variants if isinstance(variants, list) else []:
        if not isinstance(one, dict) or not isinstance(one.get("id"), str):
            raise SourceError(f"'{path / _SETTINGS}': variants: objects with an id needed")
        engram.register(
            one["id"],
            base=one.get("base"),
            constants=one.get("constants") or {},
            instruction=one.get("instruction"),
        )


def _document(path: Path) -> dict[str, Any]:
    with checks.reading(path):
        if path.stat().st_size > _LARGEST_RESULT:
            raise DatasetError(f"more than {_LARGEST_RESULT >> 20} MB")
        document = json.loads(path.read_bytes())
        if not isinstance(document, dict):
            raise DatasetError("an object needed")
        return document


def _episodes(path: Path) -> list[dict[str, Any]]:
    document = _document(path)
    with checks.reading(path):
        columns = [document[name] for name in ("episode_seeds", "episode_lengths", "successes")]
        if len({len(column) for column in columns}) != 1 or len(columns[0]) > _MOST_EPISODES:
            raise DatasetError("lists of seeds, lengths and successes of different lengths")
        return [
            {
                "seed": str(checks.whole_number("seed", seed, 0, 2**64 - 1)),
                "steps": checks.whole_number("length", steps, 0, checks.MAX_STEPS),
                "success": bool(success),
            }
            for seed, steps, success in zip(*columns)
        ]


def _index(values: Any, index: int, what: str) -> int:
    if index >= len(values):
        raise SourceError(f"no {what} {index}; there are {len(values)}")
    return index


def _at(values: Any, index: int, what: str) -> Any:
    return values[_index(values, index, what)]
