"""The engram command of wheels: a program beside this file, started in this one's place."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import NoReturn


def main() -> NoReturn:
    """Becomes the command, with the arguments of this process."""
    folder = Path(__file__).parent
    os.environ["ENGRAM_PYTHON"] = sys.executable  # for films: video.py
    # Text in pictures looks the same everywhere, with fonts on the system or without.
    os.environ.setdefault("FONTCONFIG_FILE", str(folder / "fonts.conf"))
    os.execv(folder / "engram", ["engram", *sys.argv[1:]])
