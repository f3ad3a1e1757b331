"""Targets of the form FILE:ID."""

from __future__ import annotations

import pytest

import engram
from engram import kit


@pytest.mark.parametrize(
    ("target", "parts"),
    [
        ("my_tasks.py:LampOrder-v0", ("my_tasks.py", "LampOrder-v0")),
        ("/a folder/my.tasks.py:X-v1", ("/a folder/my.tasks.py", "X-v1")),
        ("my_tasks.py", ("my_tasks.py", None)),
        ("my_tasks.py:", ("my_tasks.py", None)),
        ("RememberColor3-VLA-v0", (None, "RememberColor3-VLA-v0")),
        ("name:LampOrder-v0", (None, "name:LampOrder-v0")),
    ],
)
def test_targets_have_a_file_and_an_id(target, parts):
    assert kit.split_target(target) == parts


def test_files_that_do_not_work_are_refused(tmp_path):
    with pytest.raises(engram.IoError, match=r"none\.py: no such file"):
        kit.load_file(tmp_path / "none.py")
    file = tmp_path / "empty_tasks.py"
    file.write_text("x = 1\n")
    with pytest.raises(engram.InvalidArgumentError, match="registers no task"):
        kit.load_file(file)
    file.write_text("1 / 0\n")
    with pytest.raises(ZeroDivisionError):
        kit.load_file(file)
