#!/usr/bin/env python3
"""Checks the fragments of changelog.d, and moves them into CHANGELOG.md with --build.

A fragment is changelog.d/SECTION.NAME.md: one or more points, each "* " and sentences, further
lines indented by two spaces. --build adds them to the sections of the first, unreleased version.
"""

import argparse
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TITLES = {
    "physics": "Physics",
    "tasks": "Tasks and rules",
    "batches": "Batches",
    "evaluation": "Evaluation",
    "data": "Data sets",
    "learners": "Learners",
    "interfaces": "Interfaces",
    "packages": "Security and packages",
}
NAME = re.compile(r"([a-z]+)\.[a-z0-9_]+\.md")
WIDTH = 130


class FragmentError(Exception):
    """A fragment is not well formed, or has no place in the changelog."""


def points_of(file):
    """Section and text of a fragment."""
    named = NAME.fullmatch(file.name)
    if named is None or named[1] not in TITLES:
        allowed = ", ".join(TITLES)
        raise FragmentError(f"{file.name}: SECTION.NAME.md needed; sections: {allowed}")
    text = file.read_text().rstrip("\n")
    for number, line in enumerate(text.split("\n"), 1):
        if not re.match(r"(\* |  )\S", line) or (number == 1 and not line.startswith("* ")):
            raise FragmentError(f"{file.name}:{number}: '* ' or two spaces, and text needed")
        if len(line) > WIDTH:
            raise FragmentError(f"{file.name}:{number}: {len(line)} characters; {WIDTH} allowed")
    if not all(point.endswith(".") for point in re.split(r"\n(?=\* )", text)):
        raise FragmentError(f"{file.name}: a point ends without a full stop")
    return named[1], text


def fragments_in(folder):
    return [file for file in sorted(folder.iterdir()) if file.name != "README.md"]


def with_points(changelog, section, text):
    """The changelog with a fragment at the end of a section of its first version."""
    first = changelog.index("\n## ")
    head = changelog[first:].split("\n", 2)[1]
    if "(unreleased)" not in head:
        raise FragmentError(f"CHANGELOG.md: '{head}' is first; an unreleased version needed")
    after = changelog.find("\n## ", first + 1)
    end = after if after >= 0 else len(changelog)
    title = f"\n### {TITLES[section]}\n"
    begin = changelog.find(title, first, end)
    if begin < 0:
        return f"{changelog[:end].rstrip()}\n{title}\n{text}\n{changelog[end:]}"
    following = changelog.find("\n### ", begin + 1, end)
    end = following if following >= 0 else end
    return f"{changelog[:end].rstrip()}\n{text}\n{changelog[end:]}"


def build(root):
    """Moves all fragments into the changelog."""
    changelog = root / "CHANGELOG.md"
    files = fragments_in(root / "changelog.d")
    text = changelog.read_text()
    for file in files:
        text = with_points(text, *points_of(file))
    changelog.write_text(text)
    for file in files:
        file.unlink()
    return len(files)


def main(given=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", action="store_true", help="moves them into CHANGELOG.md")
    parser.add_argument("--root", type=Path, default=ROOT, help="of the repository")
    options = parser.parse_args(given)
    try:
        if options.build:
            print(f"{build(options.root)} fragments moved into CHANGELOG.md")
        for file in fragments_in(options.root / "changelog.d"):
            points_of(file)
    except FragmentError as error:
        sys.exit(f"changelog.d: {error}")


if __name__ == "__main__":
    main()
