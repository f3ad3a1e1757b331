"""Folders of the command line: demonstrations of `engram collect`, results of `engram eval`."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

import engram
from engram.datasets import DemonstrationFolder, checks, find_folders
from engram.datasets.checks import DatasetError, printable
from engram.play.episode_spec import EpisodeSpec
from engram.play.playback import Policy, recorded_policy
from engram.play.result_documents import read_result

BUILTIN = ("oracle", "sweep", "blind", "random", "zero")
PROCESS = "process"
_SETTINGS = "settings.json"
_MOST_EPISODES = 100_000
_MOST_STEPS = 2**31 - 1  # of an evaluated episode; recorded_policy's are fewer
_MOST_SEED = 2**64 - 1


class SourceError(Exception):
    """A folder of the command line cannot be used; the message gives the reason."""


@dataclasses.dataclass(frozen=True)
class Recording:
    """An episode of a folder: how to play it again, and how it ended then."""

    spec: EpisodeSpec
    policy: Policy
    obs_mode: str
    success: bool
    steps: int
    most_steps: int | None = None  # of recorded actions


PolicyByName = Callable[[str], tuple[Policy, str]]


class Folder(Protocol):
    """What the page can choose from."""

    def message(self) -> dict[str, Any]: ...

    def recording(self, task: int, episode: int, policy: PolicyByName) -> Recording: ...


def open_folder(path: Path) -> Folder:
    """Reads what the page shows of a folder. Raises SourceError."""
    try:
        if (path / "data_npz").is_dir():
            return Demonstrations(path)
        if (path / _SETTINGS).is_file():
            return Results(path)
    except DatasetError as error:
        raise SourceError(str(error)) from error
    raise SourceError(
        f"--folder: '{path}' given; a folder with data_npz (of `engram collect`) or settings.json "
        "(results of `engram eval`) needed"
    )


def _require_this_version(path: Path, version: Any) -> None:
    """In other versions, the same seeds are other episodes."""
    if version != engram.__version__:
        raise SourceError(
            f"'{path}' is of engram {printable(str(version))}, and this is engram "
            f"{engram.__version__}, whose episodes are others; watch it with that version"
        )


class Demonstrations:
    """Demonstrations, of `engram collect` or of the page."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._data_sets: list[DemonstrationFolder] = find_folders(path)
        for folder in self._data_sets:
            origin = folder.metadata.get("engram", {})
            _require_this_version(folder.metadata_path, origin.get("version"))

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
        return {"name": printable(self._path.name), "kind": "demonstrations", "tasks": tasks}

    def recording(self, task: int, episode: int, _policy: PolicyByName) -> Recording:
        folder = _at(self._data_sets, task, "data set")
        stored = folder[_index(folder, episode, "episode")]
        made_how = folder.metadata.get("engram", {})
        return Recording(
            EpisodeSpec(
                folder.env_id,
                stored.episode_seed,
                rules=str(made_how.get("rules", "reference")),
                physics=str(made_how.get("physics", "engram")),
                perturb=_table(folder.metadata_path, made_how, "perturbations"),
            ),
            recorded_policy(list(stored.action)),
            "state",
            success=True,
            steps=len(stored),
            most_steps=len(stored),
        )


class Results:
    """Results of `engram eval`. They have no actions; the policy acts again."""

    def __init__(self, path: Path) -> None:
        self._path = path
        settings = read_result(path / _SETTINGS)
        _require_this_version(path / _SETTINGS, settings.get("version"))
        self._policy = printable(str(settings.get("policy")))
        # Only engram's own policies have no description; another one may have any name.
        self._is_own = self._policy in BUILTIN and settings.get("policy_config") is None
        self._rules = str(settings.get("rules", "reference"))
        self._physics = str(settings.get("physics", "engram"))
        self._options = _table(path / _SETTINGS, settings, "task_options")
        self._constants = _table(path / _SETTINGS, settings, "constants")
        self._perturb = _table(path / _SETTINGS, settings, "perturbations")
        _register(path, settings)
        self._tasks = []
        ids = settings.get("tasks")
        for id in ids if isinstance(ids, list) else []:
            file = path / f"{checks.env_id('tasks', id)}.json"
            if file.is_file():
                self._tasks.append((id, _episodes(file, id)))
        if not self._tasks:
            raise SourceError(f"'{path}' holds no results of a finished task")

    def message(self) -> dict[str, Any]:
        tasks = [{"id": id, "episodes": episodes} for id, episodes in self._tasks]
        return {
            "name": printable(self._path.name),
            "kind": "results",
            "policy": self._policy[:100],
            "tasks": tasks,
        }

    def recording(self, task: int, episode: int, policy: PolicyByName) -> Recording:
        id, episodes = _at(self._tasks, task, "task")
        then = _at(episodes, episode, "episode")
        try:
            actor, obs = policy(self._policy if self._is_own else PROCESS)
        except SourceError:
            raise SourceError(
                f"the policy '{self._policy}' has to be given again: --policy-command"
            ) from None
        spec = EpisodeSpec(
            id,
            int(then["seed"]),
            constants=self._constants,
            options=self._options,
            rules=self._rules,
            physics=self._physics,
            perturb=self._perturb,
        )
        return Recording(spec, actor, obs, success=then["success"], steps=then["steps"])


def _table(file: Path, document: dict[str, Any], name: str) -> dict[str, Any]:
    """Names and values of a file's document; the simulator checks their meaning."""
    table = document.get(name) or {}
    if not isinstance(table, dict):
        raise SourceError(f"'{file}': {name}: an object needed")
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


def _episodes(path: Path, id: str) -> list[dict[str, Any]]:
    document = read_result(path)
    _require_this_version(path, document.get("version"))
    with checks.reading(path):
        if document["env_id"] != id:
            raise DatasetError(f"env_id: {checks.short(document['env_id'])} given; '{id}' needed")
        if document["episode_seeds"] is None:
            raise DatasetError("a sealed run, whose seeds are not known yet")
        columns = [document[name] for name in ("episode_seeds", "episode_lengths", "successes")]
        if len({len(column) for column in columns}) != 1 or len(columns[0]) > _MOST_EPISODES:
            raise DatasetError("lists of seeds, lengths and successes of different lengths")
        return [
            {
                "seed": str(checks.whole_number("seed", seed, 0, _MOST_SEED)),
                "steps": checks.whole_number("length", steps, 0, _MOST_STEPS),
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
