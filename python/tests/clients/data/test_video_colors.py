"""Colours of videos in LeRobot data sets, as two decoders see them.

torchcodec, which needs FFmpeg's libraries, converts by them as PyAV does.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import av
import cv2
import numpy as np
import pytest

import engram
from engram.datasets.lerobot.videos import VideoFile

STREAM = (1, 6, 6, 6)  # tv, smpte170m


def by_pyav(file: Path) -> np.ndarray:
    with av.open(str(file)) as container:
        return np.stack([frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)])


def by_opencv(file: Path) -> np.ndarray:
    video = cv2.VideoCapture(str(file))
    frames = []
    while (read := video.read())[0]:
        frames.append(read[1][..., ::-1])
    return np.stack(frames)


DECODERS = [by_pyav, by_opencv]


def encoded(folder: Path, images: np.ndarray, codec: str = "libx264") -> Path:
    file = folder / "video.mp4"
    video = VideoFile(file, images.shape[1:3], 20, codec)
    video.add(images)
    video.close()
    return file


@pytest.mark.parametrize("codec", ["libx264", "libsvtav1"])
def test_the_stream_says_which_matrix_and_range(tmp_path: Path, codec: str) -> None:
    with av.open(str(encoded(tmp_path, np.zeros((2, 128, 128, 3), np.uint8), codec))) as container:
        context = container.streams.video[0].codec_context
        found = (
            context.color_range,
            context.colorspace,
            context.color_primaries,
            context.color_trc,
        )
        assert found == STREAM


@pytest.mark.parametrize("decode", DECODERS)
@pytest.mark.parametrize("env_id", ["RememberColor9-VLA-v0", "ShellGameTouch-VLA-v0"])
def test_the_mean_colour_stays(
    tmp_path: Path, env_id: str, decode: Callable[[Path], np.ndarray]
) -> None:
    env = engram.make_vec(env_id, 1, obs_mode="rgb")
    rgb = [env.reset(seed=0)[0]["rgb"][0].copy()]
    for _ in range(29):
        rgb.append(env.step(env.act("oracle"))[0]["rgb"][0].copy())
    images = np.stack(rgb)
    for camera in (images[..., :3], images[..., 3:]):
        shift = decode(encoded(tmp_path, camera)).astype(float) - camera
        assert np.abs(shift.mean(axis=(0, 1, 2))).max() < 0.5


@pytest.mark.parametrize("decode", DECODERS)
def test_the_nine_colours_of_the_tasks_stay_nearest_to_themselves(
    tmp_path: Path, decode: Callable[[Path], np.ndarray]
) -> None:
    colors = np.array(
        [
            (255, 0, 0),
            (0, 255, 0),
            (0, 0, 255),
            (255, 255, 0),
            (255, 0, 255),
            (0, 255, 255),
            (128, 0, 0),
            (255, 128, 0),
            (0, 128, 128),
        ],
        np.uint8,
    )
    images = np.broadcast_to(colors[:, None, None], (9, 128, 128, 3))
    seen = decode(encoded(tmp_path, images)).astype(float)
    distances = np.linalg.norm(seen[:, :, :, None] - colors.astype(float), axis=-1)
    assert (distances.argmin(axis=-1) == np.arange(9)[:, None, None]).all()
    shift = seen.mean(axis=(1, 2)) - colors
    assert np.abs(shift).max() < 4
