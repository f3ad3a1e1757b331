"""The command `engram play`, and `python -m engram.play`."""

from __future__ import annotations

import argparse
import os
import shlex
import sys
from pathlib import Path
from typing import NoReturn

from engram._distribution import install_command
from engram.servers.options import add_arguments

_GRACE = 10  # seconds for the bridge to report that its server is late
_MISSING = "engram play: {}; `{}` installs what the server needs"


def main(arguments: list[str] | None = None) -> int:
    options = parser().parse_args(arguments)
    import engram

    try:
        from engram.datasets.checks import printable
        from engram.play import app
        from engram.play.folders import SourceError
    except ModuleNotFoundError as error:
        print(_MISSING.format(error, install_command("play")), file=sys.stderr)
        return 1
    try:
        for file in options.tasks:
            engram.load_tasks(file)
        for file in options.variants:
            engram.load_variants(file)
        if options.policy_server is not None:
            from engram.servers.options import bridge_command

            options.policy_command = bridge_command(options)
            options.policy_timeout += _GRACE
        if options.id is not None:
            engram.describe(options.id)  # or an error that names ids like it
        return app.serve(options)
    except (SourceError, OSError, engram.Error) as error:
        print(f"engram play: {printable(str(error))}", file=sys.stderr)
        return 1


def parser() -> argparse.ArgumentParser:
    """Options of the command; the page itself can change none of them."""
    result = argparse.ArgumentParser(
        prog="engram play",
        description="Opens a page to choose, play and watch episodes, and ends with it.",
    )
    result.add_argument(
        "id", nargs="?", metavar="ID", help="the task to begin with; default: the page asks"
    )
    result.add_argument("--port", type=_port, default=0, help="default: a free one (0 to 65535)")
    result.add_argument(
        "--host",
        default="127.0.0.1",
        help="address to listen at, default 127.0.0.1: this machine only",
    )
    result.add_argument(
        "--no-open", action="store_true", help="prints the address and opens no browser"
    )
    result.add_argument(
        "--out",
        type=_path,
        default=Path("played"),
        metavar="DIR",
        help="folder for saved episodes, DIR/data_npz/<id>; default: played",
    )
    result.add_argument(
        "--folder",
        type=_path,
        action="append",
        default=[],
        metavar="DIR",
        help="demonstrations (of `engram collect`) or results (of `engram eval`) to watch; "
        "may be given several times",
    )
    policies = result.add_mutually_exclusive_group()
    policies.add_argument(
        "--policy-command",
        type=_command,
        metavar="COMMAND",
        help="a policy's process to watch, as for `engram eval`",
    )
    policies.add_argument(
        "--policy-server", metavar="URL", help="a policy server to watch, as for `engram eval`"
    )
    add_arguments(result)
    result.add_argument(
        "--policy-timeout",
        type=_seconds,
        default=300,
        metavar="SECONDS",
        help="limit for every answer of that process, 1 to 86400, default 300",
    )
    result.add_argument(
        "--obs",
        choices=("rgb", "objects", "state"),
        default="rgb",
        help="observations of that process, default rgb",
    )
    result.add_argument(
        "--tasks",
        type=_path,
        action="append",
        default=[],
        metavar="FILE",
        help="loads a library of tasks (docs/cpp_tasks.md)",
    )
    result.add_argument(
        "--variants",
        type=_path,
        action="append",
        default=[],
        metavar="FILE",
        help="registers the variants of a file (docs/variants.md)",
    )
    result.add_argument(
        "--perturb",
        type=_perturbation,
        action="append",
        default=[],
        metavar="AXIS=LEVEL",
        help="departures from the usual scene, from 0 to 1 (docs/variants.md)",
    )
    result.add_argument(
        "--physics",
        choices=("engram", "mujoco"),
        default="engram",
        help="engine that moves robot and props, default engram (docs/physics.md)",
    )
    result.add_argument(
        "--choices",
        action="store_true",
        help="begins with answers by name: the page asks, a scripted hand acts (docs/choices.md)",
    )
    result.add_argument(
        "--stay", action="store_true", help="keeps running when the page is closed, until Ctrl-C"
    )
    return result


def _perturbation(text: str) -> tuple[str, float]:
    axis, _, level = text.partition("=")
    try:
        return axis, float(level)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} given; AXIS=LEVEL needed") from None


def _path(text: str) -> Path:
    if not text or "\0" in text:
        raise argparse.ArgumentTypeError(f"{text!r} given; the name of a folder needed")
    return Path(text)


def _command(text: str) -> str:
    try:
        words = shlex.split(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text!r} given; {error}") from None
    if not words:
        raise argparse.ArgumentTypeError(f"{text!r} given; a command needed")
    return text


def _number(text: str, low: int, high: int) -> int:
    if not text.isascii() or not text.isdigit() or not low <= int(text[:9]) <= high:
        raise argparse.ArgumentTypeError(
            f"{text!r} given; a whole number from {low} to {high} needed"
        )
    return int(text[:9])


def _port(text: str) -> int:
    return _number(text, 0, 65535)


def _seconds(text: str) -> int:
    return _number(text, 1, 86400)


def run() -> NoReturn:
    """The whole command."""
    code = main()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)  # without waiting for pictures that are still computed


if __name__ == "__main__":
    run()
