"""The command `python -m engram.mikasa`: runs a program that was written for the original."""

from __future__ import annotations

import argparse
import os
import runpy
import sys

from engram.errors import Error
from engram.mikasa._alias_modules import PACKAGES_TEXT, install, install_in_children
from engram.mikasa._original_names import PACKAGES

_USAGE = (
    "python -m engram.mikasa [-h] [--force] [--rules NAME] (PROGRAM | -m MODULE) [ARGUMENT ...]"
)


def main(arguments: list[str] | None = None) -> None:
    words = sys.argv[1:] if arguments is None else arguments
    own, program, rest = _split(words)
    parser = _parser()
    options = parser.parse_args(own)
    if program is None:
        parser.error("a PROGRAM, or -m MODULE, is needed")
    module = program if "-m" in own else None
    if module is not None and module.partition(".")[0] in PACKAGES:
        parser.error(
            f"-m {module}: engram stands in for this package; run the original's file by its path"
        )
    if module is None and not os.path.exists(program):
        parser.error(f"PROGRAM: {program!r} given, a file needed")
    if module is None and not getattr(sys.flags, "safe_path", False):
        sys.path[0] = os.path.dirname(os.path.realpath(program))  # as `python PROGRAM` has it
    try:
        install(force=options.force or None)
    except Error as error:
        print(f"engram.mikasa: {error}", file=sys.stderr)
        sys.exit(1)
    if options.rules is not None:
        os.environ["ENGRAM_RULES"] = options.rules
    sys.argv = [program, *rest]
    install_in_children(options.force)
    if module is None:
        runpy.run_path(program, run_name="__main__")
    else:
        runpy.run_module(module, run_name="__main__", alter_sys=True)


def _split(words: list[str]) -> tuple[list[str], str | None, list[str]]:
    """Options of this command, the program or module, and that one's arguments."""
    after_rules = False  # `--rules NAME` takes the next word
    for i, word in enumerate(words):
        if after_rules:
            after_rules = False
            continue
        after_rules = word == "--rules"
        if word == "-m":
            return words[: i + 1], *_first(words[i + 1 :])
        if not word.startswith("-"):
            return words[:i], *_first(words[i:])
        if word == "--":
            return words[:i], *_first(words[i + 1 :])
    return words, None, []


def _first(words: list[str]) -> tuple[str | None, list[str]]:
    return (words[0], words[1:]) if words else (None, [])


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m engram.mikasa",
        usage=_USAGE,
        allow_abbrev=False,
        description="Runs a Python program that was written for MIKASA-Robo-VLA, unedited: "
        f"its imports of {PACKAGES_TEXT} are served by engram.mikasa. Python programs "
        "that it starts have them, too. Names that engram does not have are refused with a "
        "sentence. docs/mikasa.md lists what there is.",
        epilog="Everything after PROGRAM or MODULE belongs to the program. What pip installed "
        'as a command is a PROGRAM, too: "$(which vla-eval)".',
    )
    parser.add_argument(
        "--force",
        action="store_true",
        help="hide installed packages of these names, with a warning; without it they are "
        "refused (ENGRAM_MIKASA_FORCE=1 does the same)",
    )
    parser.add_argument(
        "--rules",
        choices=("original", "reference"),
        help="rules of the original's code, or of its documentation, where gym.make has no `rules` "
        "(ENGRAM_RULES does the same)",
    )
    parser.add_argument(
        "-m",
        action="store_true",
        help="run a module by its name, as `python -m MODULE` does",
    )
    return parser


if __name__ == "__main__":
    main()
