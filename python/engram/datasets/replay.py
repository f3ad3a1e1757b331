"""Plays stored actions in fresh environments and compares what they show with what is stored.

An episode is determined by its task, its seed and its actions: `engram.make(id, obs_mode="rgb")`,
with the options of the metadata, `reset(seed=seed)`, then one `step` per action.
"""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from engram.datasets import additions, checks
from engram.datasets.checks import DatasetError
from engram.datasets.episodes import Metadata, no_progress
from engram.datasets.readers import READERS
from engram.datasets.stored import StoredEpisode
from engram.datasets.work import in_order


def differences(env, episode: StoredEpisode, succeeds: bool = True) -> list[str]:
    """Plays one episode; returns what is not the same bit for bit, the first step of each field.

    env: an `engram.Env` of the episode's task with the obs_mode of what is stored. succeeds:
    whether the episode ends with success.
    """
    observation, _ = env.reset(seed=episode.seed)
    found: dict[str, str] = {}

    def check(field: str, step: int, shown, stored) -> None:
        if stored is None or field in found:
            return
        if shown is None:
            raise DatasetError(f"{field}: stored, but not listed in the metadata")
        shown = np.asarray(shown, stored.dtype)
        if shown.tobytes() != np.ascontiguousarray(stored[step]).tobytes():
            found[field] = f"{field} of step {step}"

    if env.language_instruction != episode.language_instruction:
        found["language_instruction"] = "language_instruction"
    stored_rows = episode.rows()
    for step, action in enumerate(episode.action):
        check("rgb", step, observation["rgb"], episode.rgb)
        check("depth", step, observation.get("depth"), episode.depth)
        check("segmentation", step, observation.get("segmentation"), episode.segmentation)
        for name, rows in stored_rows.items():
            check(name, step, observation.get(name), rows)
        proprio = episode.spaces.proprio(observation["proprio"], episode.angles)
        check("proprio", step, proprio, episode.proprio)
        observation, reward, _, _, info = env.step(action)
        check("reward", step, reward, episode.reward)
        check("success", step, info["success"], episode.success)
    if bool(info["success"]) != succeeds:
        found["end"] = "success at the end"
    return list(found.values())


def compare(
    folder: Metadata,
    root: Path | str,
    source: str,
    episodes: int | None = None,
    progress: Callable[[int, int], None] = no_progress,
    jobs: int = 0,
) -> dict:
    """Plays the episodes of one task as one format holds them, on `jobs` threads (0: all cores)."""
    import engram  # the compiled part, which nothing else here needs

    if episodes is not None:
        checks.whole_number("episodes", episodes, 1, checks.MAX_EPISODES)
    count = min(len(folder), episodes or len(folder))
    different = {}
    steps = 0
    played = 0
    with _Environments(folder) as environments:

        def play(item: tuple[int, StoredEpisode]) -> tuple[int, list[str]]:
            number, episode = item
            with environments.one() as env:
                return len(episode.action), differences(env, episode, folder.succeeds(number))

        try:
            stored = islice(READERS[source](folder, Path(root)), count)
            with in_order(play, enumerate(stored), jobs) as results:
                for number, (length, found) in enumerate(results):
                    if found:
                        different[number] = found
                    steps += length
                    played += 1
                    progress(played, count)
        except engram.Error as error:
            raise DatasetError(f"'{folder.path}' cannot be played: {error}") from error
    if played < count:
        raise DatasetError(f"{folder.env_id}: {played} episodes as {source}, {count} expected")
    return {
        "env_id": folder.env_id,
        "format": source,
        "episodes": count,
        "steps": steps,
        "equal": not different,
        "different": different,
    }


class _Environments:
    """As many environments as threads play at a time."""

    def __init__(self, folder: Metadata) -> None:
        self._folder = folder
        self._free: list[Any] = []
        self._lock = threading.Lock()

    def __enter__(self) -> _Environments:
        return self

    def __exit__(self, *_: object) -> None:
        for env in self._free:
            env.close()

    @contextlib.contextmanager
    def one(self) -> Iterator[Any]:
        with self._lock:
            env = self._free.pop() if self._free else None
        if env is None:
            env = _environment(self._folder)
        try:
            yield env
        finally:
            with self._lock:
                self._free.append(env)


def _environment(folder: Metadata):
    """An environment with the options in the metadata."""
    import engram

    made_how = folder.metadata.get("engram", {})
    observed = (*additions.MAPS, *additions.ROWS)
    added = [name for name in observed if name in folder.additions]
    options: dict[str, Any] = {
        "obs_mode": "+".join(["rgb", *added]),
        "control_mode": folder.spaces.control_mode,
    }
    if folder.spaces.joint_proprio:
        options["joint_proprio"] = True
    variant = made_how.get("variant")
    if isinstance(variant, dict):
        options["constants"] = variant.get("constants")
    if made_how.get("perturbations"):
        options["perturb"] = made_how["perturbations"]
    return engram.make(
        folder.env_id,
        renderer=made_how.get("renderer", "cpu"),
        rules=made_how.get("rules", "reference"),
        physics=made_how.get("physics", "engram"),
        **options,
    )
