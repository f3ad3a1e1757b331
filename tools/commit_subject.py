#!/usr/bin/env python3
"""Checks the subject of a commit: one imperative line of at most 72 characters.

commit_subject.py FILE, with the message in FILE, as the commit-msg hook calls it.
"""

import argparse
import re
import sys
from pathlib import Path

LONGEST = 72
VERBS = frozenset((Path(__file__).parent / "commit_verbs.txt").read_text().split())


def problem_of(message):
    """Reason to refuse a message, or None."""
    subject = re.sub(r"^(fixup|squash|amend)! ", "", message.partition("\n")[0])
    verb = subject.partition(" ")[0]
    if verb not in VERBS:
        return f"'{subject}': '{verb}' given first, a verb of tools/commit_verbs.txt needed"
    if len(subject) > LONGEST:
        return f"'{subject}': {len(subject)} characters given, {LONGEST} allowed"
    if subject.endswith("."):
        return f"'{subject}': a full stop given, none needed"
    second = message.split("\n")[1:2]
    if second and second[0].strip() and not second[0].startswith("#"):
        return f"'{subject}': a second line given, an empty one needed before the body"
    return None


def main(given=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path, metavar="FILE", help="holds the message")
    problem = problem_of(parser.parse_args(given).file.read_text())
    if problem:
        sys.exit(problem)


if __name__ == "__main__":
    main()
