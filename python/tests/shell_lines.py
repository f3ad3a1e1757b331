"""Commands of the shell blocks of README.md and docs/, and what is allowed for each.

A line is read as a shell reads it, without running it: its options and values go through the
parser of the program, which is given one word too many and so stops before it does anything.
"""

from __future__ import annotations

import dataclasses
import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

from doc_blocks import ROOT

import engram.command

FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
# How blocks without a language begin that are shell.
SHELL_BEGINS = re.compile(r"agent=|engram [a-z]+ |python -m |python p|pip ")
TASKS = ROOT / "python/examples/own_tasks/keep_track.py"  # in place of a reader's file
NEVER = "--never"  # the word too many
# Programs of others, and what a line with one needs.
NEEDS = {
    "pip": "a network",
    "sudo": "root",
    "cmake": "a compiler",
    "openssl": "a secret",
    "sha256sum": "a secret",
    "sed": "a script of the original's",
    "lerobot-edit-dataset": "LeRobot",
    "lerobot-eval": "LeRobot",
    "torchrun": "several processes of torch",
    "nice": "LeRobot, which it starts",
    "seq": "GNU parallel",
    "kill": "the server of the line before",
    "python3": "a folder for an environment",
    "build/release/cross_entropy": "the C++ build",
}
SHELL = {"export", "cd", "."}
# Words of a page that stand for a reader's own, and what is read instead.
FOR_READERS = {
    "...": None,
    "ID...": "RememberColor3-VLA-v0",
    "$SLURM_ARRAY_TASK_ID/7": "3/7",
}
BEFORE = {"mpirun", "srun", "exec"}  # start the program behind their own options
ENGRAM = {"engram", "$engram", "build/release/engram"}
PYTHON = {"python", "build/python-env/bin/python"}


@dataclasses.dataclass(frozen=True)
class Line:
    """A command of a page, as words."""

    page: str
    line: int
    words: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.page}:{self.line}"

    @property
    def own(self) -> tuple[str, ...]:
        """Its words from a program of engram on; none for a program of others."""
        words = self.words
        if words and words[0] in BEFORE:
            at = next((i for i, word in enumerate(words) if word in ENGRAM), len(words))
            words = words[at:]
        own = bool(words) and (words[0] in {*ENGRAM, *PYTHON} or words[0].startswith("scripts/"))
        if not own:
            return ()
        return tuple(read for word in words if (read := FOR_READERS.get(word, word)) is not None)

    @property
    def ids(self) -> set[str]:
        """Ids that it names."""
        return {
            found
            for word in self.own
            for found in re.findall(r"^(?:[\w/.]+\.py:)?([A-Z][\w-]*-v\d+)$", word)
        }


def _words(line: str) -> tuple[str, ...]:
    line = re.sub(r"\d*<.*$", "", line)  # what it reads is a reader's
    lexer = shlex.shlex(line, posix=True, punctuation_chars="&|>;")
    lexer.whitespace_split = True
    words: list[str] = []
    for word in lexer:
        if set(word) <= set("&|>;"):
            break
        words.append(word)
    while words and re.match(r"^\w+=", words[0]):  # variables
        words.pop(0)
    return tuple(words)


def lines() -> list[Line]:
    """Every command of every page."""
    found = []
    for path in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]:
        text, page = path.read_text(), path.relative_to(ROOT).as_posix()
        for match in FENCE.finditer(text):
            number = text.count("\n", 0, match.start(2)) + 1
            block = match[2]
            if match[1] != "sh" and (match[1] or not SHELL_BEGINS.match(block)):
                continue
            for at, line in _joined(block):
                if words := _words(line):
                    found.append(Line(page, number + at, words))
    return found


def _joined(block: str) -> list[tuple[int, str]]:
    """Lines of a block, those that end in a backslash with the next."""
    joined: list[tuple[int, str]] = []
    begin, text = 0, ""
    for at, line in enumerate(block.splitlines()):
        begin = begin if text else at
        text += line
        if text.endswith("\\"):
            text = text[:-1]
            continue
        if not text.lstrip().startswith("#"):
            joined.append((begin, text))
        text = ""
    return joined


def read_by_engram(words: tuple[str, ...]) -> str:
    """What the command says of the words and of NEVER."""
    given = [re.sub(r"^\w+\.py(?=:|$)", str(TASKS), word) for word in words[1:]]
    program = Path(engram.command.__file__).with_name("engram")
    done = subprocess.run(
        [program, *given, NEVER],
        env={**os.environ, "ENGRAM_PYTHON": sys.executable},
        capture_output=True,
        text=True,
        stdin=subprocess.DEVNULL,
        check=False,
    )
    return done.stderr if done.returncode == 2 else f"exit code {done.returncode}: {done.stderr}"


# Modules and scripts run in one process, which loads the libraries once.
_READER = """
import contextlib, io, json, runpy, sys
answers = []
for words in json.load(sys.stdin):
    out = io.StringIO()
    module = words[0] == "-m"
    sys.argv = [words[1] if module else words[0], *words[1 + module:], "--never"]
    with contextlib.redirect_stderr(out), contextlib.redirect_stdout(out):
        try:
            if module:
                runpy.run_module(words[1], run_name="__main__", alter_sys=True)
            else:
                sys.path.insert(0, words[0].rpartition("/")[0])
                runpy.run_path(words[0], run_name="__main__")
        except SystemExit as end:
            print("exit code", end.code, file=out)
    answers.append(out.getvalue())
print(json.dumps(answers))
"""


def read_by_python(calls: list[tuple[str, ...]]) -> list[str]:
    """What the programs say of each call's words and of NEVER."""
    done = subprocess.run(
        [sys.executable, "-c", _READER],
        input=json.dumps([words[1:] for words in calls]),
        capture_output=True,
        text=True,
        cwd=ROOT,
        env=dict(os.environ),
        check=True,
    )
    answers: list[str] = json.loads(done.stdout)
    return answers
