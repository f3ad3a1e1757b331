"""Files that appear complete or not at all, and folders that links do not lead out of."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from engram._io import files


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_a_folder_is_the_same_whatever_takes_its_name(tmp_path: Path) -> None:
    outside = tmp_path / "outside"
    outside.mkdir()
    with files.open_folder(tmp_path / "out", "inner") as folder:
        (tmp_path / "out" / "inner").rename(tmp_path / "moved")
        (tmp_path / "out" / "inner").symlink_to(outside)
        files.write_file(folder, "a", b"1")
    assert names(outside) == []
    assert (tmp_path / "moved" / "a").read_bytes() == b"1"


def test_links_and_files_below_the_root_are_refused(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "link").symlink_to(tmp_path / "elsewhere")
    (tmp_path / "out" / "file").write_text("x")
    for part in ("link", "file"):
        with (
            pytest.raises(files.UnsafeFolderError, match="is a link, or no folder"),
            files.open_folder(tmp_path / "out", part, "inner"),
        ):
            pass
    assert names(tmp_path / "elsewhere") == []
    (tmp_path / "root").symlink_to(tmp_path / "elsewhere")  # the caller's choice
    with files.open_folder(tmp_path / "root", "inner"):
        assert names(tmp_path / "elsewhere") == ["inner"]


def test_a_lock_keeps_others_out(tmp_path: Path) -> None:
    with files.open_folder(tmp_path, lock=True):
        with (
            pytest.raises(files.InUseError, match="another process writes to"),
            files.open_folder(tmp_path, lock=True),
        ):
            pass
        with files.open_folder(tmp_path):
            pass
    with files.open_folder(tmp_path, lock=True):
        pass


def test_a_file_is_complete_or_as_it_was(tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "outside").write_text("theirs")
    out = tmp_path / "out"
    with files.open_folder(out) as folder:
        files.write_file(folder, "a", b"1")
        (out / "b").symlink_to(tmp_path / "outside")
        files.write_file(folder, "b", b"2")
        monkeypatch.setattr(os, "fsync", lambda _: (_ for _ in ()).throw(OSError("full")))
        with pytest.raises(OSError, match="full"):
            files.write_file(folder, "a", b"3")
    assert (tmp_path / "outside").read_text() == "theirs"
    assert names(out) == ["a", "b"]
    assert [(out / name).read_bytes() for name in ("a", "b")] == [b"1", b"2"]


def test_temporary_names_are_not_foreseeable(tmp_path: Path, monkeypatch) -> None:
    opened = []
    replace = os.replace

    def note(source, target, **folders):
        opened.append(source)
        replace(source, target, **folders)

    monkeypatch.setattr(os, "replace", note)
    with files.open_folder(tmp_path) as folder:
        for _ in range(2):
            files.write_file(folder, "a", b"1")
        assert len(set(opened)) == 2
        (tmp_path / opened[0]).write_text("half")  # as a killed process leaves it
        (tmp_path / "engram-tmp").write_text("theirs")
        files.remove_leftovers(folder)
    assert names(tmp_path) == ["a", "engram-tmp"]
