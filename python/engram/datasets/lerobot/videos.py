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

from engram.datasets.checks import DatasetError

_OF_DISKS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
# 128 x 128 images: 0.4 ms and 1.9 KB a frame, 32 dB; AV1 takes 1.7 ms and 2.2 KB for that.
_QUALITY = {
    "libx264": {"crf": "24", "preset": "veryfast"},
    "libsvtav1": {"crf": "30", "preset": "12"},
}

# Colours: BT.601 of limited range, as the stream says.
_RANGE, _SMPTE170M = 1, 6  # of FFmpeg
_TO_YUV = np.array(
    [[65.481, 128.553, 24.966], [-37.797, -74.203, 112.0], [112.0, -93.786, -18.214]], np.float32
) / np.float32(255)
# FFmpeg's conversion back to RGB, which PyAV, torchcodec and OpenCV share, is too dark by these.
_SHIFT = np.array([1.0, 1.5, 0.8], np.float32)
_OFFSET = _TO_YUV @ _SHIFT + np.array([16, 128, 128], np.float32)


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
            for image in images:
                frame = av.VideoFrame.from_ndarray(_planes(image), format="yuv420p")
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


def _planes(image: np.ndarray) -> np.ndarray:
    """An image (H, W, 3) in YUV: the rows of Y, then those of U and V at half the size.

    Channel by channel: their pixels need not lie side by side, and no image is copied for that.
    """
    height, width = image.shape[:2]
    values = np.zeros((height * 3 // 2, width), np.float32)
    luma, chroma = values[:height], values[height:].reshape(2, height // 2, width // 2)
    for channel, (y, *uv) in zip(np.moveaxis(image, -1, 0), _TO_YUV.T):
        plane = channel.astype(np.float32)
        rows = plane[::2] + plane[1::2]
        quads = rows[:, ::2] + rows[:, 1::2]
        for half, weight in zip(chroma, uv):
            half += weight / 4 * quads
        plane *= y
        luma += plane
    luma += _OFFSET[0]
    chroma += _OFFSET[1:, None, None]
    return np.rint(values, out=values).astype(np.uint8)


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
