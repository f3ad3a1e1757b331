"""`engram collect --format lerobot`: the data set without NPZ between."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from engram.datasets import lerobot
from engram.datasets.episodes import find_folders

ID = "ShellGameTouch-VLA-v0"
ENGRAM = [sys.executable, "-m", "engram", "collect"]


def collect(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*ENGRAM, *words], capture_output=True, text=True, check=False)


def files_in(folder: Path) -> dict[str, bytes]:
    """What a data set holds, without how it was made."""
    made = ("README.md", "engram.json")
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name not in made
    }


@pytest.mark.parametrize("joints", [False, True])
def test_the_same_files_as_through_npz(tmp_path, joints):
    words = [ID, "--episodes", "3", "--seed", "7", "--threads", "1"]
    words += ["--control-mode", "pd_joint_pos", "--joint-proprio"] * joints
    assert collect(*words, "--out", str(tmp_path)).returncode == 0
    folder = lerobot.convert(find_folders(tmp_path)[0], tmp_path)

    direct = tmp_path / "direct"
    done = collect(*words, "--format", "lerobot", "--out", str(direct), "--json")
    assert done.returncode == 0, done.stderr
    (result,) = json.loads(done.stdout)
    assert (result["env_id"], result["episodes"]) == (ID, 3)
    assert not (direct / "data_npz").exists()
    assert files_in(Path(result["out"])) == files_in(folder)
    replayed = [sys.executable, "-m", "engram.datasets", "replay", str(direct), "--json"]
    done = subprocess.run(
        [*replayed, "--format", "lerobot"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)[0]["equal"]


def test_what_is_there_is_left_alone_and_nothing_else_takes_its_place(tmp_path):
    words = (ID, "--episodes", "2", "--format", "lerobot", "--frames", "images")
    assert collect(*words, "--out", str(tmp_path)).returncode == 0
    folder = tmp_path / "data_lerobot" / ID
    before = files_in(folder)
    again = collect(*words, "RememberColor3-VLA-v0", "--out", str(tmp_path))
    assert again.returncode == 0
    assert f"{ID}: there already" in again.stderr
    assert {path.name for path in folder.parent.iterdir()} == {ID, "RememberColor3-VLA-v0"}
    other = collect(*words, "--seed", "3", "--out", str(tmp_path))
    assert other.returncode == 1
    assert "was collected otherwise; the same options, or another --out, needed" in other.stderr
    assert files_in(folder) == before


def test_too_few_episodes_leave_nothing(tmp_path):
    words = (ID, "--episodes", "30", "--max-attempts", "1", "--format", "lerobot")
    done = collect(*words, "--out", str(tmp_path))
    assert done.returncode == 1
    assert "of 30 episodes after 1 attempts" in done.stderr
    assert not (tmp_path / "data_lerobot" / ID).exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--format", "hdf5"), "--format: 'hdf5' given, npz, lerobot or rl allowed"),
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
