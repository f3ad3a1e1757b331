"""engram.evaluate in shards, and engram.merge."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import engram

IDS = ["RememberColor3-VLA-v0", "TakeItBack-VLA-v0"]


def policy(observation):
    angle = observation["step"][:, None] + np.arange(7) + observation["state"][:, :1]
    return np.sin(angle).astype(np.float32)


def test_shards_merge_to_the_result_of_one_process(tmp_path):
    options = {"episodes": 5, "obs": "state", "num_envs": 2}
    one = engram.evaluate(policy, IDS, **options)
    for shard in ("3/3", "1/3"):
        played = engram.evaluate(policy, IDS, output=tmp_path, shard=shard, **options)
        assert played["shard"] == shard
        assert Path(played["out"]) == tmp_path / f"shard-{shard[0]}-of-3"
        assert played["episodes"] in (3, 4)
    with pytest.raises(engram.UnavailableError, match="1 of 3 shards not finished; the first is 2"):
        engram.merge(tmp_path)
    engram.evaluate(policy, IDS, output=tmp_path, shard="2/3", **options)
    assert engram.merge(tmp_path) == one
    shards = sorted(tmp_path.glob("shard-*"))
    assert engram.merge(shards, tmp_path / "elsewhere") == one
    assert list((tmp_path / "elsewhere").glob("short/*/summary.json"))
    with pytest.raises(engram.InvalidArgumentError, match="has n_episodes 5"):
        engram.evaluate(policy, IDS, output=tmp_path, shard="2/3", **{**options, "episodes": 6})
    with pytest.raises(engram.InvalidArgumentError, match="folders: 3 given"):
        engram.merge(3)  # type: ignore[arg-type]
