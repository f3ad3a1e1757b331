"""Writes the public surface out of api/surface.toml: all blocks between "begin generated" marks.

python3 tools/surface          brings all blocks up to date
python3 tools/surface --check  exits with 1, naming the files, if one is stale
"""

import subprocess
import sys

from blocks import rewritten, squeezed
from files import FILES
from table import ROOT


def main():
    if sys.argv[1:] not in ([], ["--check"]):
        sys.exit(f"argument {sys.argv[1:]} given; allowed: --check")
    stale = []
    for file, blocks in FILES.items():
        old = (ROOT / file).read_text()
        new = rewritten(file, old, blocks)
        if new == old or (file.endswith((".cc", ".h")) and squeezed(new) == squeezed(old)):
            continue
        stale.append(file)
        if not sys.argv[1:]:
            write(ROOT / file, new)
    if stale and sys.argv[1:]:
        sys.exit("stale, run python3 tools/surface: " + ", ".join(stale))


def write(path, text):
    path.write_text(text)
    if path.suffix in (".cc", ".h"):
        subprocess.run(["clang-format", "-i", path], check=True)


if __name__ == "__main__":
    main()
