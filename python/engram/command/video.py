"""Encodes a video for the engram command, from pictures that media/video_python.cc sends.

The settings are those of media/video_libav.cc. Errors are printed on standard output.
"""

from __future__ import annotations

import signal
import sys
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from engram._distribution import install_command

_H264 = {"preset": "medium", "crf": "18"}
_THREADS = 4  # fixed: the output of x264 depends on the number
_MPEG_RANGE = 1
_BT709 = 1
_PICTURE, _PALETTE, _END = b"p", b"c", b"e"


class Stream:
    """One encoded stream in one file, .mp4 or .gif."""

    def __init__(self, file: str, kind: str, width: int, height: int, rate: int) -> None:
        import av
        from av.codec.context import Flags

        mp4 = kind == "mp4"
        self._av = av
        self._container = av.open(
            "file:" + file,  # other names with a colon would be taken for protocols
            "w",
            format=kind,
            options={"fflags": "+bitexact", **({"movflags": "+faststart"} if mp4 else {})},
        )
        stream: Any = self._container.add_stream(
            "libx264" if mp4 else "gif", rate=rate, options=_H264 if mp4 else {}
        )
        stream.width, stream.height = width, height
        stream.pix_fmt = "yuv420p" if mp4 else "pal8"
        context = stream.codec_context
        context.flags |= int(Flags.bitexact)
        if mp4:
            context.thread_count = _THREADS
            context.color_range = _MPEG_RANGE
            context.colorspace = context.color_primaries = context.color_trc = _BT709
        self._stream = stream

    def send_rgb(self, picture: npt.NDArray[np.uint8]) -> None:
        frame = self._av.VideoFrame.from_ndarray(picture, format="rgb24")
        self._send(
            frame.reformat(format="yuv420p", dst_colorspace="ITU709", dst_color_range="MPEG")
        )

    def send_indexed(self, indices: npt.NDArray[np.uint8], palette: npt.NDArray[np.uint32]) -> None:
        entries = palette.astype(">u4").view(np.uint8).reshape(256, 4)  # alpha, red, green, blue
        pair: Any = (indices, entries)  # PyAV takes it, and its types leave it out
        self._send(self._av.VideoFrame.from_ndarray(pair, format="pal8"))

    def finish(self) -> None:
        self._container.mux(self._stream.encode(None))
        self._container.close()

    def _send(self, frame: Any) -> None:
        self._container.mux(self._stream.encode(frame))


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
        elif message == _PICTURE and kind == "gif":
            stream.send_indexed(_array(source, np.uint8, height, width), palette)
        elif message == _PICTURE:
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
