"""Tasks of a file for the engram command, which starts this (apps/task_process.cc)."""

from __future__ import annotations

import sys

from engram.kit.server import serve


def run() -> None:
    serve(sys.argv[1])


if __name__ == "__main__":
    run()
