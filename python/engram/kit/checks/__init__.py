"""Checks tasks as the project's own tests check the built-in ones: ``engram check my_tasks.py``.

Checks, each in a module of its own:

* runs: episodes of all scripts and of random actions; values are finite, rewards within bounds.
* episodes: the same bits in batches of 1, 5 and 16, in other slots, with more threads, after
  partial resets, twice in a process, and in a fresh process.
* snapshots: episodes continue in other slots and batches, bit for bit.
* draws: pins and narrowed ranges are followed, draws matter, the longest phases leave time.
* constants: least and greatest values work, or are refused with a sentence.
* scripts: the oracle is at its floor, blind at chance, zero never succeeds, sweep has no memory.
* leaks: once the cue is over, episodes that differ in the hidden draw alone look the same.
* speed: steps per second beside a built-in task.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path

from engram._args import values
from engram.errors import IoError, UnknownIdError
from engram.kit.checks import constants, draws, leaks, runs, scripts, snapshots, speed
from engram.kit.checks import episodes as determinism
from engram.kit.checks.play import StoppedError, described
from engram.kit.checks.report import Finding, Report
from engram.kit.checks.subject import Settings, Subject, watched
from engram.kit.files import load_file, split_target

__all__ = ["Finding", "Report", "check"]

_CHECKS: tuple[tuple[str, Callable[[Subject], None]], ...] = (
    ("runs", runs.check),
    ("episodes", determinism.check),
    ("snapshots", snapshots.check),
    ("draws", draws.check),
    ("constants", constants.check),
    ("scripts", scripts.check),
    ("leaks", leaks.check),
    ("speed", speed.check),
)
CHECK_NAMES = tuple(name for name, _ in _CHECKS)
EPISODES, FAST_EPISODES = 200, 64


def check(
    target: str | Sequence[str],
    *,
    episodes: int | None = None,
    fast: bool = False,
    hidden: str = "",
    only: Sequence[str] = CHECK_NAMES,
) -> Report:
    """Checks tasks and says in sentences what is wrong.

    Args:
        target: A file, a file and an id ("my_tasks.py:LampOrder-v0"), an id, or several of them.
        episodes: Episodes of which success rates are measured; None: 200, or 64 if `fast`.
        fast: Fewer episodes.
        hidden: The draw that is hidden; empty: the one that the task names.
        only: Kinds of checks to run; all if not given.

    Returns:
        The findings. ``report.ok`` is whether nothing is wrong; ``str(report)`` lists them.

    Raises:
        IoError: There is no such file.
        UnknownIdError: There is no such task.
    """
    report = Report()
    targets = [target] if isinstance(target, str) else target
    fill(report, targets, episodes=episodes, fast=fast, hidden=hidden, only=only)
    return report


def fill(
    report: Report,
    targets: Sequence[str],
    *,
    episodes: int | None,
    fast: bool,
    hidden: str,
    only: Sequence[str],
) -> None:
    """What ``check`` does; the report has all that was found before a KeyboardInterrupt."""
    standard = FAST_EPISODES if fast else EPISODES
    count = standard if episodes is None else values.integer("episodes", episodes, 8, 100_000)
    for name in only:
        values.one_of("only", name, dict.fromkeys(CHECK_NAMES, 0))
    begin = time.perf_counter()
    try:
        for target in targets:
            for id, file in _found(target, report):
                _check_one(Settings(id, file, count, fast, hidden), only, report)
    finally:
        report.seconds = time.perf_counter() - begin


def _found(target: str, report: Report) -> list[tuple[str, Path | None]]:
    """Ids of a target and the file they come from; none if it cannot be loaded."""
    file, id = split_target(target)
    if file is None:
        assert id is not None
        return [(id, None)]
    try:
        ids = load_file(file)
    except IoError:
        raise
    except Exception as error:
        report.findings.append(Finding(target, "load", "wrong", described(error)))
        return []
    if id is not None and id not in ids:
        raise UnknownIdError(f"{file}: registers {', '.join(ids)}, not {id!r}")
    return [(one, Path(file).resolve()) for one in ids if id in (None, one)]


def _check_one(settings: Settings, only: Sequence[str], report: Report) -> None:
    with watched(settings.id) as tasks:
        subject = Subject(settings, report.findings, tasks)
        for name, run in _CHECKS:
            if name not in only:
                continue
            try:
                run(subject)
            except StoppedError as error:
                subject.add(name, "wrong", str(error))
                return  # the others would meet it as well
            except KeyboardInterrupt as error:
                subject.add(name, "wrong", described(error))
                raise
