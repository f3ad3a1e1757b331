"""Streams of video, by PyAV.

The settings are those of media/libav/libav_stream.cc.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

_H264 = {"preset": "medium", "crf": "18"}
_THREADS = 4  # fixed: the output of x264 depends on the number
_MPEG_RANGE = 1
_BT709 = 1


class Stream:
    """One encoded stream in one file, .mp4 or .gif."""

    def __init__(self, file: str, kind: str, width: int, height: int, rate: int | Fraction) -> None:
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

    def send_rgb(self, image: npt.NDArray[np.uint8]) -> None:
        frame = self._av.VideoFrame.from_ndarray(image, format="rgb24")
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
