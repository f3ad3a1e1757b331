"""Writes the public surface out of api/surface.toml: all blocks between "begin generated" marks."""

import argparse
import subprocess
import sys

from blocks import rewritten, squeezed
from files import FILES
from table import ROOT


def main():
    parser = argparse.ArgumentParser(prog="python3 tools/surface", description=__doc__)
    parser.add_argument(
        "--check", action="store_true", help="write nothing; exit with 1, naming stale files"
    )
    check = parser.parse_args().check
    stale = []
    for file, blocks in FILES.items():
        old = (ROOT / file).read_text()
        new = rewritten(file, old, blocks)
        if new == old or (file.endswith((".cc", ".h")) and squeezed(new) == squeezed(old)):
            continue
        stale.append(file)
        if not check:
            write(ROOT / file, new)
    if stale and check:
        sys.exit("stale, run python3 tools/surface: " + ", ".join(stale))


def write(path, text):
    path.write_text(text)
    if path.suffix in (".cc", ".h"):
        subprocess.run(["clang-format", "-i", path], check=True)


if __name__ == "__main__":
    main()
