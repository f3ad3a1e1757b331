"""Videos of episodes: engram.mikasa.record.write_video, and the name that programs import."""

from __future__ import annotations

import sys

import numpy as np
import pytest

pytest.importorskip("torch")
pytest.importorskip("av")

import av

import engram
from engram.mikasa import benchmarking, record

PICTURES = [np.full((48, 65, 3), 40 * i, np.uint8) for i in range(5)]


def frames(path):
    with av.open(str(path)) as video:
        rate = float(video.streams.video[0].average_rate)
        return rate, [frame.to_ndarray(format="rgb24") for frame in video.decode(video=0)]


def test_a_video_without_the_command(tmp_path, monkeypatch):
    """Debian's package of the Python files leaves out engram.command."""
    monkeypatch.setitem(sys.modules, "engram.command", None)
    monkeypatch.setitem(sys.modules, "engram.command.video", None)
    benchmarking._write_video(tmp_path / "new" / "film.mp4", PICTURES, fps=12.5)
    rate, seen = frames(tmp_path / "new" / "film.mp4")
    assert rate == 12.5
    assert [frame.shape for frame in seen] == [(48, 64, 3)] * 5
    for frame, picture in zip(seen, PICTURES):
        assert abs(frame.mean() - picture.mean()) < 4


@pytest.mark.parametrize("most", [1, 255])
def test_pictures_of_numbers(tmp_path, most):
    pictures = [np.full((32, 32, 3), most * i / 4) for i in range(1, 5)]
    record.write_video(tmp_path / "film.mp4", pictures, 30)
    _, seen = frames(tmp_path / "film.mp4")
    for i, frame in enumerate(seen, 1):
        assert abs(frame.mean() - 255 * i / 4) < 6


def test_no_pictures(tmp_path):
    benchmarking._write_video(tmp_path / "film.mp4", [], fps=30.0)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "pictures", [[], [*PICTURES, PICTURES[0][1:]], [PICTURES[0][..., 0]], [PICTURES[0][..., :2]]]
)
def test_pictures_that_are_no_film(tmp_path, pictures):
    with pytest.raises(engram.InvalidArgumentError, match="images of one shape"):
        record.write_video(tmp_path / "film.mp4", pictures, 30)
    assert not list(tmp_path.iterdir())


def test_without_pyav_or_with_an_old_one(tmp_path, monkeypatch):
    monkeypatch.setattr(av, "__version__", "9.2.0")
    with pytest.raises(engram.UnavailableError, match=r"film.mp4: videos need PyAV 12 .* not 9.2"):
        record.write_video(tmp_path / "film.mp4", PICTURES, 30)
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(engram.UnavailableError, match="videos need PyAV: pip install"):
        record.write_video(tmp_path / "film.mp4", PICTURES, 30)
    assert not list(tmp_path.iterdir())
