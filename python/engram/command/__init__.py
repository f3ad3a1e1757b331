"""The engram command of wheels: a program beside this file, started in this one's place."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import NoReturn


def main() -> NoReturn:
    """Replaces this process by the command, with the same arguments.

    ``--cmake-dir`` alone prints the folder of the CMake package that libraries of tasks are built
    with (docs/cpp_tasks.md), and ``servers check`` asks a policy server (docs/policy_servers.md).
    """
    folder = Path(__file__).parent
    if sys.argv[1:] == ["--cmake-dir"]:
        print(folder.parent / "lib" / "cmake" / "engram")
        sys.exit()
    if sys.argv[1:3] == ["servers", "check"]:
        from engram.servers.__main__ import run

        del sys.argv[1]
        run()
    os.environ["ENGRAM_PYTHON"] = sys.executable  # for videos: video.py
    # Text in images has the same font everywhere.
    os.environ.setdefault("FONTCONFIG_FILE", str(folder / "fonts.conf"))
    os.execv(folder / "engram", ["engram", *sys.argv[1:]])
