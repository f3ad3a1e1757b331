"""Every line of shell in README.md and docs/ is one that its program takes."""

from __future__ import annotations

import os
import re

import pytest
from doc_blocks import ROOT
from shell_lines import (
    NEEDS,
    NEVER,
    PYTHON,
    SHELL,
    Line,
    lines,
    read_by_engram,
    read_by_python,
)

import engram

LINES = lines()
OWN = [line for line in LINES if line.own]
COMMANDS = [line for line in OWN if line.own[0].endswith("engram")]
MODULES = [line for line in OWN if line.own[0] in PYTHON]
SCRIPTS = [line for line in OWN if line.own[0].startswith("scripts/")]


def test_each_line_is_read_or_says_what_it_needs() -> None:
    for line in LINES:
        name = line.words[0]
        assert line.own or name in NEEDS or name in SHELL, f"{line}: {name} is read by no test"
    assert len(COMMANDS) >= 90


@pytest.mark.parametrize("name", NEEDS)
def test_each_need_is_that_of_a_line(name: str) -> None:
    assert any(line.words[0] == name for line in LINES)


@pytest.mark.parametrize("line", COMMANDS, ids=str)
def test_the_command_takes_the_line(line: Line) -> None:
    words = line.own
    if "check" in words:  # which loads files by itself
        words = tuple(word for word in words if not word.endswith(".py"))
    if words[1:2] == ("--tasks",) and words[2].endswith(".so"):
        words = (words[0], *words[3:])  # a library that the page builds
    said = read_by_engram(words)
    assert f"unexpected '{NEVER}'" in said, f"{line}: {' '.join(line.words)}\n{said}"


def test_programs_in_python_take_their_lines() -> None:
    # Learners load torch, which takes longer than all other lines.
    programs = (("-m", "engram.datasets"), ("-m", "engram.servers"))
    read = [line for line in MODULES if line.own[1:3] in programs]
    for line, said in zip(read, read_by_python([line.own for line in read]), strict=True):
        assert re.search(rf"unrecognized arguments: {NEVER}\nexit code 2", said), f"{line}\n{said}"
    assert len(read) >= 5


def test_scripts_and_their_options_are_there() -> None:
    for line in SCRIPTS:
        script = ROOT / line.own[0]
        assert os.access(script, os.X_OK), line
        for word in line.own[1:]:
            if word.startswith("--out") or line.own[1] == "record":  # of the command
                continue
            assert not word.startswith("-") or word in script.read_text(), f"{line}: {word}"


def test_ids_are_those_of_tasks() -> None:
    known = {task["id"] for task in engram.list()}
    for line in OWN:
        page = (ROOT / line.page).read_text()
        for id in line.ids - known:
            base = id.removesuffix("-VLA-v0").removesuffix("-v0")
            added = re.search(rf'"{base}[^"\n]*"', page)
            assert added, f"{line}: {id} is no task, and the page adds none"
