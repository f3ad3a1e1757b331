"""The original's released wheel, for tests that run its files."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

WHEEL = "mikasa-robo-suite==1.0.0"
MODULES = Path(__file__).with_name("mikasa")  # that programs of these tests import


@pytest.fixture(scope="session")
def wheel(tmp_path_factory):
    """The original's wheel from the package index; skips without a network."""
    folder = tmp_path_factory.mktemp("original")
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "-d", str(folder)]
    done = subprocess.run([*command, WHEEL], capture_output=True, text=True, timeout=300)
    if done.returncode != 0:
        pytest.skip(f"no network: {done.stderr.strip().splitlines()[-1]}")
    return zipfile.ZipFile(next(folder.glob("*.whl")))


def unpacked(wheel, path, folder):
    """Writes a file of the wheel into the folder, unchanged; returns where it lies."""
    script = folder / path.rsplit("/", 1)[1]
    script.write_bytes(wheel.read(path))
    return script


def run(*words, folder, code=0, **environment):
    """`python WORDS` in a folder, with the modules of these tests; returns the finished process."""
    paths = [str(MODULES), *filter(None, [os.environ.get("PYTHONPATH")])]
    done = subprocess.run(
        [sys.executable, *map(str, words)],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(paths), **environment},
        capture_output=True,
        text=True,
        timeout=1800,
    )
    assert done.returncode == code, done.stdout + done.stderr
    return done


def check_collected(data, id="RememberColor3-VLA-v0"):
    """The collector's files are complete, and engram reads them."""
    import engram.mikasa
    from engram.datasets.episodes import DemonstrationFolder

    folder = data / "data_npz" / engram.mikasa.env_id_to_dataset_name(id)
    metadata = json.loads((folder / "metadata.json").read_text())
    assert metadata["num_episodes"] >= 10
    episodes = DemonstrationFolder(folder)
    assert len(episodes) == metadata["num_episodes"]
    for episode in episodes:
        steps = len(episode)
        assert episode.rgb.shape == (steps, 128, 128, 6)
        assert episode.proprio.shape == episode.action.shape == (steps, 7)
        assert episode.success[-1]
        assert episode.language_instruction == engram.describe(id)["instruction"]
