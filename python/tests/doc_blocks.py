"""Blocks of code in README.md and docs/, run as a reader pastes them: each in a process of its own.

A block whose first line is a comment "Goes on from ..." finds the files that the blocks before it
have written, but none of their names.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FENCE = re.compile(r"^```(python|sh)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
# Libraries that have an environment of their own.
ELSEWHERE = re.compile(
    r"^(?:import|from) (tensorflow_datasets|lerobot|pufferlib|inspect_robots|openenv"
    r"|engram\.integrations\.ray)\b",
    re.MULTILINE,
)


@dataclass(frozen=True)
class Block:
    """A block of Python or shell; line: that of its first line in the page."""

    page: str
    line: int
    language: str
    text: str

    def __str__(self) -> str:
        return f"{self.page}:{self.line}"

    @property
    def goes_on(self) -> bool:
        return self.text.startswith("# Goes on from ")

    @property
    def elsewhere(self) -> str | None:
        """The library that the block imports, if that has an environment of its own."""
        found = ELSEWHERE.search(self.text) if self.language == "python" else None
        return found[1] if found else None

    def run(self, folder: Path) -> str:
        """Runs the block in the folder; returns what it prints."""
        # Empty lines before it, so that tracebacks have the line numbers of the page.
        script = folder / "pasted.py"
        script.write_text("\n" * (self.line - 1) + self.text)
        shell = ["bash", "-euc", self.text]
        command = [sys.executable, script] if self.language == "python" else shell
        path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
        done = subprocess.run(
            command, cwd=folder, env={**os.environ, "PATH": path}, capture_output=True, text=True
        )
        assert done.returncode == 0, f"{self}\n{done.stdout}\n{done.stderr}"
        return done.stdout


def groups() -> list[list[Block]]:
    """Every block of the pages, with those that go on from it."""
    found: list[list[Block]] = []
    for path in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]:
        text, page = path.read_text(), path.relative_to(ROOT).as_posix()
        for match in FENCE.finditer(text):
            line = text.count("\n", 0, match.start(2)) + 1
            block = Block(page, line, match[1], match[2])
            if block.goes_on:
                assert found[-1][0].page == page, f"{block}: there is no block before it"
                found[-1].append(block)
            else:
                found.append([block])
    return found


def checkout(folder: Path) -> Path:
    """The folder, with what blocks name of a checkout."""
    (folder / "build" / "release").mkdir(parents=True)
    (folder / "build" / "release" / "engram").symlink_to(Path(sys.executable).parent / "engram")
    (folder / "python").symlink_to(ROOT / "python")
    return folder


def run_all(blocks: Iterable[Block], folder: Path) -> str:
    """Runs them one after the other; returns what they print."""
    checkout(folder)
    return "".join(block.run(folder) for block in blocks)
