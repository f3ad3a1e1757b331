"""The engram command of wheels, as users start it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import av
import numpy as np
import pytest

import engram

TASK = "RememberColor3-VLA-v0"
HORIZON = 25
IDS = [task["id"] for task in engram.list()]  # before other tests register variants


def run(*words: object, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "engram", *map(str, words)],
        capture_output=True,
        text=True,
        env={**os.environ, **environment},
        check=False,
    )


def pictures(path: Path) -> list[np.ndarray]:
    with av.open(str(path)) as video:
        return [frame.to_ndarray(format="rgb24") for frame in video.decode(video=0)]


def test_info_lists_segmentation_names():
    done = run("info", TASK, "--obs", "rgb+segmentation", "--json")
    assert done.returncode == 0, done.stderr
    names = json.loads(done.stdout)["segmentation_names"]
    assert names == engram.describe(TASK, obs_mode="rgb+segmentation")["segmentation_names"]
    assert len(names) == len(set(names)) > 12


def test_knows_the_same_tasks_as_the_package():
    done = run("list", "--json")
    assert done.returncode == 0, done.stderr
    assert [task["id"] for task in json.loads(done.stdout)] == IDS


@pytest.mark.parametrize(
    "command",
    "list info rollout eval collect record play bench soak verify doctor".split(),  # noqa: SIM905
)
def test_has_all_subcommands(command):
    done = run(command, "--help")
    assert done.returncode == 0
    assert "Usage" in done.stdout


def test_the_script_beside_python_is_the_same():
    script = Path(sys.executable).with_name("engram")
    done = subprocess.run([script, "--version"], capture_output=True, text=True, check=True)
    assert done.stdout == run("--version").stdout


def test_exit_codes_are_the_commands_own():
    done = run("rollout", "NoSuchTask-v0")
    assert done.returncode == 2
    assert "NoSuchTask-v0" in done.stderr


@pytest.mark.parametrize("name", ["video.mp4", "video.gif", "with: colon.mp4"])
def test_films_have_every_frame(tmp_path, name):
    path = tmp_path / name
    done = run("record", TASK, "--seed", 1, "--out", path, "--hold", "0,0")
    assert done.returncode == 0, done.stderr
    frames = pictures(path)
    assert len(frames) == HORIZON + 1
    assert [entry.name for entry in tmp_path.iterdir()] == [name]
    assert np.abs(frames[0].astype(int) - frames[-1]).max() > 50


def test_films_are_the_same_bytes_again(tmp_path):
    videos = [tmp_path / "a.mp4", tmp_path / "b.mp4"]
    for video in videos:
        assert run("record", TASK, "--seed", 1, "--out", video).returncode == 0
    assert videos[0].read_bytes() == videos[1].read_bytes()


def test_colours_of_a_film_are_those_of_a_picture(tmp_path):
    arguments = ("record", TASK, "--seed", 3)
    assert run(*arguments, "--out", tmp_path / "video.mp4").returncode == 0
    assert run(*arguments, "--out", tmp_path / "sheet.png", "--at", 0).returncode == 0
    from PIL import Image

    sheet = np.asarray(Image.open(tmp_path / "sheet.png").convert("RGB"), int)
    video = pictures(tmp_path / "video.mp4")[0].astype(int)
    height, width = (min(a, b) for a, b in zip(sheet.shape, video.shape[:2]))
    corner = np.s_[height // 4 : height // 2, width // 4 : width // 2]
    assert np.abs(sheet[corner].mean((0, 1)) - video[corner].mean((0, 1))).max() < 8


def test_without_pyav_the_error_names_it(tmp_path):
    (tmp_path / "av.py").write_text("raise ImportError('no av')")
    video = tmp_path / "video.mp4"
    done = run("record", TASK, "--out", video, PYTHONPATH=str(tmp_path))
    assert done.returncode == 1
    assert "pip install av" in done.stderr
    assert not video.exists()


def test_failed_videos_leave_no_files(tmp_path):
    folder = tmp_path / "video.mp4"
    folder.mkdir()
    done = run("record", TASK, "--out", folder)
    assert done.returncode != 0
    assert "video.mp4" in done.stderr
    assert list(tmp_path.iterdir()) == [folder]
