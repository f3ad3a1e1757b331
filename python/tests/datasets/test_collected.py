"""`engram collect --format lerobot`, `rlds` and `hdf5`: data sets without NPZ between."""

from __future__ import annotations

import importlib
import importlib.util
import json
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from engram.datasets.episodes import find_folders

ID = "ShellGameTouch-VLA-v0"
ENGRAM = [sys.executable, "-m", "engram", "collect"]


FORMATS = [
    "lerobot",
    "rlds",
    pytest.param(
        "hdf5",
        marks=pytest.mark.skipif(importlib.util.find_spec("h5py") is None, reason="no h5py"),
    ),
]


def collect(*words: str, **how: Any) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*ENGRAM, *words], capture_output=True, text=True, check=False, **how)


def files_in(folder: Path) -> dict[str, bytes]:
    """What a data set holds, without how it was made."""
    made = ("README.md", "engram.json")
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name not in made
    }


@pytest.mark.parametrize("joints", [False, True])
@pytest.mark.parametrize("format", FORMATS)
def test_the_same_files_as_through_npz(tmp_path, format, joints):
    words = [ID, "--episodes", "3", "--seed", "7", "--threads", "1"]
    words += ["--control-mode", "pd_joint_pos", "--joint-proprio"] * joints
    assert collect(*words, "--out", str(tmp_path)).returncode == 0
    writer = importlib.import_module(f"engram.datasets.{format}")
    folder = writer.convert(find_folders(tmp_path)[0], tmp_path)

    direct = tmp_path / "direct"
    done = collect(*words, "--format", format, "--out", str(direct), "--json")
    assert done.returncode == 0, done.stderr
    (result,) = json.loads(done.stdout)
    assert (result["env_id"], result["format"], result["episodes"]) == (ID, format, 3)
    assert not (direct / "data_npz").exists()
    assert files_in(Path(result["out"])) == files_in(folder)
    replayed = [sys.executable, "-m", "engram.datasets", "replay", str(direct), "--json"]
    done = subprocess.run(
        [*replayed, "--format", format], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)[0]["equal"]


@pytest.mark.parametrize("format", FORMATS)
def test_what_is_there_is_left_alone_and_nothing_else_takes_its_place(tmp_path, format):
    words = [ID, "--episodes", "2", "--format", format]
    words += ["--frames", "images"] * (format == "lerobot")
    assert collect(*words, "--out", str(tmp_path)).returncode == 0
    folder = tmp_path / f"data_{format}" / ID
    before = files_in(folder)
    again = collect(*words, "RememberColor3-VLA-v0", "--out", str(tmp_path))
    assert again.returncode == 0
    assert f"{ID}: there already" in again.stderr
    assert {path.name for path in folder.parent.iterdir()} == {ID, "RememberColor3-VLA-v0"}
    for changed in (["--seed", "3"], ["--depth"]):
        other = collect(*words, *changed, "--out", str(tmp_path))
        assert other.returncode == 1
        assert "was collected otherwise; the same options, or another --out" in other.stderr
        assert files_in(folder) == before


@pytest.mark.parametrize("format", FORMATS)
def test_too_few_episodes_leave_nothing(tmp_path, format):
    words = (ID, "--episodes", "30", "--max-attempts", "1", "--format", format)
    done = collect(*words, "--out", str(tmp_path))
    assert done.returncode == 1
    assert "of 30 episodes after 1 attempts" in done.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("format", FORMATS)
def test_an_interruption_leaves_what_was_there(tmp_path, format):
    assert collect(ID, "--episodes=2", "--format", format, "--out", str(tmp_path)).returncode == 0
    before = files_in(tmp_path)
    words = [ID, "RememberColor3-VLA-v0", "--episodes", "2", "--format", format]
    # The stream of the second one has begun, too, when the first one is interrupted.
    both = [words[1], "ShellGamePush-VLA-v0"]
    long = [*both, "--episodes", "100000", "--format", format, "--out", str(tmp_path)]
    process = subprocess.Popen(
        [*ENGRAM, *long],
        stderr=subprocess.PIPE,
        start_new_session=True,
        # Runs in the background have it ignored.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    unfinished = tmp_path / f"data_{format}"
    while not any(path.stat().st_size > 100_000 for path in unfinished.rglob("*.engram-tmp/**/*")):
        assert process.poll() is None
        time.sleep(0.05)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    error = process.communicate(timeout=60)[1].decode()  # ends when no process is left
    assert process.returncode == 130
    assert "Traceback" not in error
    assert files_in(tmp_path) == before
    assert collect(*words, "--out", str(tmp_path)).returncode == 0
    assert {path.name for path in unfinished.iterdir()} == set(words[:2])


@pytest.mark.parametrize("format", FORMATS)
def test_a_full_disk_leaves_what_was_there(tmp_path, format):
    words = ["--episodes=2", "--format", format, "--out", str(tmp_path)]
    assert collect(ID, *words).returncode == 0
    before = files_in(tmp_path)

    def limit() -> None:  # of files; Python ignores the signal
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))

    done = collect("RememberColor3-VLA-v0", "ShellGamePush-VLA-v0", *words, preexec_fn=limit)
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    (message,) = [line for line in done.stderr.splitlines() if line]
    assert message.startswith("engram.datasets: '")
    assert message.endswith(" cannot be written: File too large")
    assert files_in(tmp_path) == before


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--format", "zarr"), "--format: 'zarr' given, npz, lerobot, rlds, hdf5 or rl allowed"),
        (("--format", "rlds", "--stream"), "one of them allowed"),
        (
            ("--format", "rlds", "--frames", "images"),
            "--format rlds with --frames=images, an option of lerobot",
        ),
        (("--format", "lerobot", "--estimate"), "one of them allowed"),
        (("--format", "lerobot", "--control-mode", "pd_ee_pose"), "oracle with control mode"),
        (("--codec", "libx264"), "--codec requires --format"),
    ],
)
def test_wrong_options(tmp_path, words, message):
    done = collect(ID, *words, "--out", str(tmp_path))
    assert done.returncode == 2
    assert message in done.stderr
    assert not list(tmp_path.iterdir())
