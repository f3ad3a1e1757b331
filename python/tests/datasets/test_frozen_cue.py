"""Marks of actions that were not executed in converted sets."""

from __future__ import annotations

import json

import numpy as np
import pytest

pytest.importorskip("pyarrow")
pytest.importorskip("av")
pytest.importorskip("h5py")
pytest.importorskip("google_crc32c")

import h5py
import pyarrow.parquet as pq

import engram
from engram.datasets import find_folders, frozen, hdf5, lerobot, rlds
from engram.datasets.readers import READERS
from engram.tasks import describe, list_tasks

FROZEN = [task["id"] for task in list_tasks() if describe(task["id"])["frozen_cue"]]
ID = "RememberColor3-VLA-v0"


class Episode:
    """What a mask depends on."""

    def __init__(self, seed: int) -> None:
        self.episode_seed = seed

    def __len__(self) -> int:
        return 60


def steps_without_effect(env_id: str, seed: int, **options) -> int:
    """How many first actions change nothing."""
    envs = [engram.make(env_id, **options) for _ in range(2)]
    for env in envs:
        env.reset(seed=seed)
    for step in range(60):
        shown = [env.step(np.full(7, sign, np.float32))[0] for env, sign in zip(envs, (1, -1))]
        if not np.array_equal(*shown):
            return step
    raise AssertionError


@pytest.mark.parametrize("env_id", FROZEN)
def test_the_mask_is_of_actions_without_effect(env_id: str) -> None:
    cue = frozen.FrozenCue(env_id, {"rules": "reference"})
    for seed in (5, 4_242_424_242):
        assert cue.mask(Episode(seed)).sum() == steps_without_effect(env_id, seed)
    cue.close()


def test_words_of_a_collection_count() -> None:
    words = ["--episodes", "3", "--set", "CUE_PHASE_STEPS=2,3", "--rules=original"]
    origin = frozen.origin_of_words(words)
    assert origin == {"rules": "original", "variant": {"constants": {"CUE_PHASE_STEPS": [2, 3]}}}
    cue = frozen.FrozenCue(ID, origin)
    found = cue.mask(Episode(1)).sum()
    options = {"rules": "original", "constants": {"CUE_PHASE_STEPS": [2, 3]}}
    assert found == steps_without_effect(ID, 1, **options)


def test_sets_hold_the_mask_and_say_so(demonstrations, tmp_path) -> None:
    folder = find_folders(demonstrations, [ID])[0]
    expected = [steps_without_effect(ID, episode.episode_seed) for episode in folder]
    path = lerobot.convert(folder, tmp_path, frames="images")
    rows = pq.read_table(path / "data/chunk-000/file-000.parquet").to_pydict()
    marked = np.array(rows["is_action_frozen"])
    assert [marked[np.array(rows["episode_index"]) == i].sum() for i in (0, 1)] == expected
    features = json.loads((path / "meta" / "info.json").read_text())["features"]
    assert features["is_action_frozen"]["dtype"] == "bool"
    # LeRobot takes what begins with "action" for an output of policies.
    assert [name for name in features if name.startswith("action")] == ["action"]
    stats = json.loads((path / "meta" / "stats.json").read_text())
    assert stats["is_action_frozen"]["mean"] == [pytest.approx(marked.mean())]
    assert set(stats) == set(features)
    with h5py.File(hdf5.convert(folder, tmp_path) / "demonstrations.hdf5") as file:
        stored = [file[f"data/demo_{i}/is_action_frozen"][:].sum() for i in (0, 1)]
    assert stored == expected
    assert "is_action_frozen" in (rlds.convert(folder, tmp_path) / "features.json").read_text()
    for card in tmp_path.rglob("README.md"):
        assert "The first actions were not executed" in card.read_text()
    for source in ("rlds", "lerobot", "hdf5"):
        assert len(list(READERS[source](folder, tmp_path))) == 2


def test_others_have_none(demonstrations, tmp_path) -> None:
    folder = find_folders(demonstrations, ["InterceptSlow-VLA-v0"])[0]
    path = lerobot.convert(folder, tmp_path, frames="images")
    names = pq.read_schema(path / "data/chunk-000/file-000.parquet").names
    assert "is_action_frozen" not in names
    assert "not executed" not in (path / "README.md").read_text()
    assert not frozen.FrozenCue(ID, {})  # the original's own draws
