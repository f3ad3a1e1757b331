"""Refusals of the converters and of their command."""

from __future__ import annotations

import shutil
import subprocess
import sys

import pytest
from demonstrations import IDS

from engram.datasets import DatasetError, find_folders
from engram.datasets.__main__ import main


def test_damaged_files_are_reported(demonstrations, tmp_path, capsys):
    target = tmp_path / "data_npz" / IDS[0]
    shutil.copytree(demonstrations / "data_npz" / IDS[0], target)
    file = target / "train_data_1.npz"
    whole = file.read_bytes()
    for damaged in (b"", whole[: len(whole) // 2], whole[:5000] + b"????" + whole[5004:]):
        file.write_bytes(damaged)
        assert main(["rlds", str(tmp_path), "--jobs", "1"]) == 1
        assert "train_data_1.npz" in capsys.readouterr().err
        # Nothing half-written is left behind.
        assert not list((tmp_path / "data_rlds").rglob("*.*"))
    file.unlink()
    with pytest.raises(DatasetError, match="is missing"):
        find_folders(tmp_path)
    assert main(["lerobot", str(tmp_path / "nothing")]) == 1
    assert "has no folder data_npz" in capsys.readouterr().err
    with pytest.raises(DatasetError, match=IDS[1]):
        find_folders(tmp_path, [IDS[1]])


def test_runs_as_a_module():
    result = subprocess.run(
        [sys.executable, "-m", "engram.datasets", "--help"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert "lerobot" in result.stdout
