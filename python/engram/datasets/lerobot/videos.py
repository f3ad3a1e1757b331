"""Video files of LeRobotDataset, through FFmpeg."""

from __future__ import annotations

import contextlib
import errno
import os
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any, BinaryIO

import av
import numpy as np

from engram import _core
from engram.datasets.checks import DatasetError

_OF_DISKS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
# 128 x 128 images: 0.25 ms and 1.7 KB a frame, 39 dB of Y, U and V; with the preset veryfast and
# crf 24 0.45 ms and 1.4 KB for that. AV1 takes 1.7 ms.
_QUALITY = {
    "libx264": {"crf": "26", "preset": "ultrafast", "coder": "cabac"},
    "libsvtav1": {"crf": "30", "preset": "12"},
}

# Colours: BT.601 of limited range, as the stream says.
_RANGE, _SMPTE170M = 1, 6  # of FFmpeg
_TO_YUV = np.array(
    [[65.481, 128.553, 24.966], [-37.797, -74.203, 112.0], [112.0, -93.786, -18.214]], np.float32
) / np.float32(255)
# FFmpeg's conversion back to RGB, which PyAV, torchcodec and OpenCV share, is too dark by these.
_SHIFT = np.array([1.0, 1.5, 0.8], np.float32)
_OFFSET = (_TO_YUV @ _SHIFT + [16, 128, 128]).astype(np.float32)


class VideoFile:
    """One MP4 file, which grows by frames."""

    def __init__(self, target: Path | BinaryIO, size: tuple[int, int], fps: int, codec: str):
        self.fps = fps
        self.codec = codec
        self.frames = 0
        self.bytes = 0  # of what the encoder has given so far
        with _encoding(codec):
            if isinstance(target, Path):
                target.parent.mkdir(parents=True, exist_ok=True)
                self.container: Any = av.open(str(target), "w")
            else:
                self.container = av.open(target, "w", format="mp4")
            os.environ.setdefault("SVT_LOG", "1")  # errors only
            # A key frame at every other frame, so that any frame is found quickly.
            options = {"g": "2", **_QUALITY.get(codec, {"crf": "30"})}
            self.stream: Any = self.container.add_stream(codec, rate=fps, options=options)
            self.stream.codec_context.thread_count = 1  # images are small; cameras have theirs
            self.stream.pix_fmt = "yuv420p"
            self.stream.height, self.stream.width = size
            context = self.stream.codec_context
            context.color_range = _RANGE
            context.colorspace = context.color_primaries = context.color_trc = _SMPTE170M

    def add(self, images: np.ndarray) -> None:
        """Appends frames, (T, H, W, 3) bytes."""
        with _encoding(self.codec):
            frames, height, width = images.shape[:3]
            planes = np.empty((frames, height * 3 // 2, width), np.uint8)
            _core.to_yuv420(images, _TO_YUV, _OFFSET, planes)
            for image in planes:
                frame = av.VideoFrame.from_numpy_buffer(image, format="yuv420p")
                frame.pts = self.frames
                frame.time_base = Fraction(1, self.fps)
                self._mux(self.container, self.stream.encode(frame))
                self.frames += 1

    def close(self) -> None:
        if self.container is not None:
            container, self.container = self.container, None  # closed once, even if that fails
            with _encoding(self.codec), container:
                self._mux(container, self.stream.encode())

    def _mux(self, container: Any, packets: Any) -> None:
        for packet in packets:
            self.bytes += packet.size
            container.mux(packet)


def video_info(path: Path, fps: int, codec: str) -> dict[str, Any]:
    """Properties of a file, for info.json."""
    with _encoding(codec), av.open(str(path)) as container:
        stream = container.streams.video[0]
        return {
            "video.height": stream.height,
            "video.width": stream.width,
            "video.codec": stream.codec.canonical_name,
            "video.pix_fmt": stream.pix_fmt,
            "video.is_depth_map": False,
            "video.fps": fps,
            "video.channels": 3,
            "has_audio": False,
        }


@contextlib.contextmanager
def _encoding(codec: str) -> Iterator[None]:
    """Tells what FFmpeg refuses: an encoder that it lacks, or that takes no such images.

    A full disk is an OSError.
    """
    try:
        yield
    except (av.FFmpegError, ValueError, TypeError, AttributeError) as error:
        number = getattr(error, "errno", None)
        if number in _OF_DISKS:
            raise OSError(number, os.strerror(number)) from error
        raise DatasetError(f"codec: {codec!r} given; FFmpeg says: {error}") from error
