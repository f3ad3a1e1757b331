"""The command `engram check`, and `python -m engram.kit.checks`."""

from __future__ import annotations

import argparse
import json
import sys

from engram import errors

_INTERRUPTED = 130


def parser() -> argparse.ArgumentParser:
    from engram.kit.checks import CHECK_NAMES, EPISODES, FAST_EPISODES

    found = argparse.ArgumentParser(
        prog="engram check",
        description="Checks tasks as engram's own tests check the built-in ones, and says what is "
        "wrong. Exit status: 0 nothing is wrong, 1 something is, 2 wrong usage.",
    )
    found.add_argument("target", nargs="+", metavar="FILE.py[:ID]|ID", help="tasks to check")
    found.add_argument(
        "--episodes", type=int, metavar="INT",
        help=f"episodes of success rates; default: {EPISODES}, with --fast {FAST_EPISODES}",
    )  # fmt: skip
    found.add_argument("--fast", action="store_true", help="fewer episodes")
    found.add_argument("--json", action="store_true", help="prints the report as JSON")
    found.add_argument(
        "--hidden",
        default="",
        metavar="DRAW",
        help="draw that is hidden, if it is another one than the task names",
    )
    found.add_argument(
        "--only", action="append", choices=CHECK_NAMES, help="a kind of checks (repeatable)"
    )
    found.add_argument(
        "--tasks", action="append", default=[], metavar="FILE",
        help="loads a file or library of tasks (repeatable)",
    )  # fmt: skip
    found.add_argument(
        "--variants", action="append", default=[], metavar="FILE",
        help="registers the variants of a file (repeatable)",
    )  # fmt: skip
    found.add_argument("--digests", action="store_true", help=argparse.SUPPRESS)
    return found


def main(arguments: list[str] | None = None) -> int:
    options = parser().parse_args(arguments)
    from engram.gym_registration import load_variants
    from engram.kit.checks import CHECK_NAMES, Report, fill
    from engram.kit.files import load_tasks

    report, status = Report(), None
    try:
        for file in options.tasks:
            load_tasks(file)
        for file in options.variants:
            load_variants(file)
        if options.digests:
            print(json.dumps(_digests(options.target[0])))
            return 0
        fill(
            report, options.target, episodes=options.episodes, fast=options.fast,
            hidden=options.hidden,
            only=options.only or CHECK_NAMES,
        )  # fmt: skip
    except errors.Error as error:
        print(f"engram check: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        status = _INTERRUPTED
    print(json.dumps(report.document(), indent=2) if options.json else report)
    return status if status is not None else int(not report.ok)


def _digests(target: str) -> dict[str, list[str]]:
    """What an episode's outputs are in this process."""
    from engram.kit.checks.episodes import digests
    from engram.kit.checks.subject import Settings, Subject, watched
    from engram.kit.files import load_file, split_target

    file, id = split_target(target)
    if file is not None:
        load_file(file)
    assert id is not None
    with watched(id) as tasks:
        return digests(Subject(Settings(id), [], tasks))


def run() -> None:
    """For the engram command."""
    sys.exit(main())


if __name__ == "__main__":
    run()
