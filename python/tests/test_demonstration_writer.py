"""Episodes that are kept in a folder: all or nothing, and repaired at the next one."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest
from sound_dataset import ID, arrays_of

import engram
from engram.datasets import DatasetError, DemonstrationFolder, Episode, demonstration_writer

FOLDER = Path("data_npz") / ID


def episode(number: int) -> Episode:
    arrays = arrays_of(number)
    for name in ("language_instruction", "success_once", "episode_length", "episode_seed"):
        arrays[name] = arrays[name].item()
    return Episode(**arrays)


def keep(out: Path, number: int) -> int:
    return demonstration_writer.append_episode(
        out, ID, episode(number), player="a test", version=engram.__version__
    )[1]


def seeds(out: Path) -> list[int]:
    return [one.episode_seed for one in DemonstrationFolder(out / FOLDER)]


def test_episodes_are_appended(tmp_path: Path) -> None:
    assert [keep(tmp_path, number) for number in range(3)] == [1, 2, 3]
    assert seeds(tmp_path) == [0, 1, 2]


@pytest.mark.parametrize("kept", [0, 1])
@pytest.mark.parametrize("failing", [1, 2])
def test_a_full_disk_changes_nothing(tmp_path: Path, monkeypatch, kept: int, failing: int) -> None:
    for number in range(kept):
        keep(tmp_path, number)
    before = {path.name for path in (tmp_path / FOLDER).glob("*")}
    sync, calls = os.fsync, []

    def full(descriptor: int) -> None:
        calls.append(descriptor)
        if len(calls) == failing:  # the data, or the metadata
            raise OSError(errno.ENOSPC, "No space left on device")
        sync(descriptor)

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", full)
        with pytest.raises(DatasetError, match=f"{ID}.* cannot be written: .*No space left"):
            keep(tmp_path, 7)
    assert {path.name for path in (tmp_path / FOLDER).glob("*")} == before
    assert keep(tmp_path, 8) == kept + 1
    assert seeds(tmp_path) == [*range(kept), 8]


KILLED = """
import os, sys
from pathlib import Path
import test_demonstration_writer as tests
replace = os.replace
calls = []
def stop(*paths, **folders):
    calls.append(paths)
    if len(calls) == int(sys.argv[2]):
        os._exit(9)
    replace(*paths, **folders)
os.replace = stop
tests.keep(Path(sys.argv[1]), 7)
"""


@pytest.mark.parametrize("kept", [0, 1])
@pytest.mark.parametrize("when", [1, 2])
def test_a_kill_is_repaired_by_the_next_episode(tmp_path: Path, kept: int, when: int) -> None:
    for number in range(kept):
        keep(tmp_path, number)
    killed = subprocess.run(
        [sys.executable, "-c", KILLED, str(tmp_path), str(when)],
        cwd=Path(__file__).parent,
        check=False,
    )
    assert killed.returncode == 9
    if kept:
        assert seeds(tmp_path) == [0]
    assert keep(tmp_path, 8) == kept + 1
    assert seeds(tmp_path) == [*range(kept), 8]
    assert not [path for path in (tmp_path / FOLDER).iterdir() if "tmp" in path.name]


def test_files_of_others_stay(tmp_path: Path) -> None:
    keep(tmp_path, 0)
    theirs = tmp_path / FOLDER / "train_data_1.npz"
    theirs.write_text("the only copy")
    with pytest.raises(DatasetError, match=r"train_data_1\.npz' is damaged, or not engram's"):
        keep(tmp_path, 1)
    assert theirs.read_text() == "the only copy"
    theirs.unlink()
    theirs.symlink_to(tmp_path / FOLDER / "train_data_0.npz")
    with pytest.raises(DatasetError, match="is a link"):
        keep(tmp_path, 1)
    other = tmp_path / "other" / FOLDER
    other.mkdir(parents=True)
    (other / "notes.txt").write_text("mine")
    with pytest.raises(DatasetError, match="holds other files"):
        keep(tmp_path / "other", 1)
