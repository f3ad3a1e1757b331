"""`engram collect --keep-failures`: episodes that fail are kept, and said to be failures."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pytest

from engram.datasets import frozen, lerobot, replay
from engram.datasets.checks import DatasetError
from engram.datasets.episodes import find_folders

pq = pytest.importorskip("pyarrow.parquet")

# The oracle's joints are too slow for many of these.
WORDS = ("RememberColor9-VLA-v0", "--control-mode", "pd_joint_delta_pos", "--episodes", "8")


@pytest.fixture(scope="module")
def collected(tmp_path_factory):
    out = tmp_path_factory.mktemp("failures")
    command = [sys.executable, "-m", "engram", "collect", *WORDS, "--keep-failures"]
    subprocess.run([*command, "--out", str(out)], check=True, capture_output=True)
    return out


def test_every_seed_is_there_with_its_result(collected):
    (folder,) = find_folders(collected)
    assert folder.metadata["episode_seeds"] == list(range(8))
    successes = folder.metadata["success_once"]
    assert 0 < sum(successes) < 8
    for episode, success in zip(folder, successes):
        assert episode.success_once is success
        assert episode.success[-1] == success
        assert episode.done[-1] == 1
        assert len(episode) == 25 or success


def test_conversion_and_replay(collected, tmp_path):
    (folder,) = find_folders(collected)
    assert replay.compare(folder, collected, "npz")["equal"]
    path = lerobot.convert(folder, collected, frames="images")
    rows = pq.read_table(path / "meta" / "episodes" / "chunk-000" / "file-000.parquet")
    assert rows["episode_success"].to_pylist() == folder.metadata["success_once"]
    assert replay.compare(folder, collected, "lerobot")["equal"]
    card = (path / "README.md").read_text()
    assert f"| successes | {sum(folder.metadata['success_once'])} |" in card
    assert "--keep-failures" in card

    words = [*WORDS, "--keep-failures", "--format", "lerobot", "--frames", "images"]
    command = [sys.executable, "-m", "engram", "collect", *words, "--out", str(tmp_path)]
    subprocess.run(command, check=True, capture_output=True)
    direct = tmp_path / "data_lerobot" / WORDS[0] / "meta" / "episodes"
    assert pq.read_table(direct / "chunk-000" / "file-000.parquet").equals(rows)


def test_rlds_says_which_ends_are_terminal(collected):
    pytest.importorskip("google_crc32c")
    from engram.datasets import rlds, tf_example

    (folder,) = find_folders(collected)
    cue = frozen.FrozenCue(folder.env_id, folder.origin)
    for episode in folder:
        fields = tf_example.parse_example(rlds.serialize(episode, folder.env_id, (), cue))
        rest, success = [0] * (len(episode) - 1), int(episode.success_once)
        assert fields["steps/is_last"] == [*rest, 1]
        assert fields["steps/is_terminal"] == [*rest, success]  # truncated, all failures here
        assert fields["steps/discount"] == [1.0 - one for one in [*rest, success]]
    failure = folder[folder.metadata["success_once"].index(False)]
    cue.horizon = len(failure) + 1
    fields = tf_example.parse_example(rlds.serialize(failure, folder.env_id, (), cue))
    assert fields["steps/is_terminal"][-1] == 1
    cue.close()


def test_a_failure_among_successes_is_refused(collected, tmp_path):
    (folder,) = find_folders(collected)
    first = folder.metadata["success_once"].index(False)
    with np.load(folder.files[first]) as file:
        arrays = dict(file)
    arrays["success_once"] = np.array(True)
    np.savez(tmp_path / "a.npz", **arrays)
    with pytest.raises(DatasetError, match="success is not 0 until the last step and 1 in that"):
        type(folder[first]).load(tmp_path / "a.npz", folder.spaces)
    assert json.loads(folder.metadata_bytes)["engram"]["keep_failures"] is True
