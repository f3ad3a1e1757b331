"""Encodes a video for the engram command, from images that media/video_python.cc sends.

Errors are printed on standard output.
"""

from __future__ import annotations

import signal
import sys
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from engram._distribution import install_command
from engram._io.video import Stream

_IMAGE, _PALETTE, _END = b"p", b"c", b"e"


def _array(source: BinaryIO, dtype: npt.DTypeLike, *shape: int) -> npt.NDArray[Any]:
    size = int(np.prod(shape)) * np.dtype(dtype).itemsize
    return np.frombuffer(source.read(size), dtype).reshape(shape)


def encode(source: BinaryIO, file: str, kind: str, width: int, height: int, rate: int) -> None:
    """Writes the file from the messages of `source`; leaves it unfinished without a final one."""
    stream = Stream(file, kind, width, height, rate)
    palette = np.zeros(256, np.uint32)
    while message := source.read(1):
        if message == _PALETTE:
            palette = _array(source, np.uint32, 256)
        elif message == _IMAGE and kind == "gif":
            stream.send_indexed(_array(source, np.uint8, height, width), palette)
        elif message == _IMAGE:
            stream.send_rgb(_array(source, np.uint8, height, width, 3))
        elif message == _END:
            stream.finish()
            return


def main() -> int:
    # The command handles Ctrl-C and ends this process.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    file, kind, *numbers = sys.argv[1:]
    width, height, rate = map(int, numbers)
    try:
        encode(sys.stdin.buffer, file, kind, width, height, rate)
    except ImportError:
        print(f"videos need PyAV: {install_command('video')}", end="")
        return 1
    except Exception as error:
        print(error, end="")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
