"""Writes the public surface out of api/surface.toml: all blocks between "begin generated" marks.

python3 scripts/surface          brings all blocks up to date
python3 scripts/surface --check  exits with 1, naming the files, if one is stale
"""

import sys

from blocks import rewritten
from files import FILES
from table import ROOT


def main():
    if sys.argv[1:] not in ([], ["--check"]):
        sys.exit(f"argument {sys.argv[1:]} given; allowed: --check")
    stale = []
    for file, blocks in FILES.items():
        old = (ROOT / file).read_text()
        new = rewritten(file, old, blocks)
        if new != old:
            stale.append(file)
            if not sys.argv[1:]:
                (ROOT / file).write_text(new)
    if stale and sys.argv[1:]:
        sys.exit("stale, run python3 scripts/surface: " + ", ".join(stale))


if __name__ == "__main__":
    main()
