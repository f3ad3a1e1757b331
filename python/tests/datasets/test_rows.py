"""Rows of the modes "state" and "objects" in demonstrations and converted data sets."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pyarrow")
pytest.importorskip("av")
pytest.importorskip("google_crc32c")

import engram
from engram.datasets import find_folders
from engram.datasets.__main__ import main
from engram.datasets.episodes import find_metadata
from engram.datasets.readers import READERS

ID = "RememberColor3-VLA-v0"
ROWS = ("state", "objects")
FORMATS = ["rlds", "lerobot"] + ["hdf5"] * (importlib.util.find_spec("h5py") is not None)
COLLECT = [sys.executable, "-m", "engram", "collect", ID, "--episodes", "2", "--threads", "2"]


@pytest.fixture(scope="module", params=ROWS)
def collected(request, tmp_path_factory) -> tuple[str, Path]:
    folder = tmp_path_factory.mktemp(request.param)
    command = [*COLLECT, f"--{request.param}", "--out", str(folder)]
    subprocess.run(command, check=True, capture_output=True)
    return request.param, folder


def test_they_are_what_environments_show(collected):
    name, root = collected
    (folder,) = find_folders(root)
    env = engram.make(ID, obs_mode=f"rgb+{name}")
    for episode in folder:
        observation, _ = env.reset(seed=episode.episode_seed)
        for step, action in enumerate(episode.action):
            for field in ("rgb", name):
                np.testing.assert_array_equal(getattr(episode, field)[step], observation[field])
            observation, *_ = env.step(action)
    env.close()


@pytest.mark.parametrize("format", FORMATS)
def test_formats_hold_them_where_asked_for(collected, tmp_path, format, capsys):
    name, root = collected
    (source,) = find_folders(root)
    for words in ([f"--{name}"], []):
        assert main([format, str(root), *words, "--out", str(tmp_path)]) == 0
        (folder,) = find_metadata(tmp_path, format)
        for episode, stored in zip(source, READERS[format](folder, tmp_path)):
            expected = {name: getattr(episode, name)} if words else {}
            assert stored.rows().keys() == expected.keys()
            for key, values in expected.items():
                np.testing.assert_array_equal(stored.rows()[key], values)
        capsys.readouterr()
        assert main(["replay", str(tmp_path), "--format", format, "--json"]) == 0
        assert json.loads(capsys.readouterr().out)[0]["equal"]


def test_replay_finds_another_number(collected, tmp_path, capsys):
    name, root = collected
    target = tmp_path / "data_npz" / ID
    target.mkdir(parents=True)
    for file in (root / "data_npz" / ID).iterdir():
        (target / file.name).write_bytes(file.read_bytes())
    with np.load(target / "train_data_1.npz") as file:
        arrays = dict(file)
    arrays[name][2, 3] += 0.25
    np.savez(target / "train_data_1.npz", **arrays)
    assert main(["replay", str(tmp_path), "--json"]) == 1
    assert json.loads(capsys.readouterr().out)[0]["different"] == {"1": [f"{name} of step 2"]}


def test_policies_of_lerobot_do_not_take_them_for_inputs(collected, tmp_path):
    name, root = collected
    assert main(["lerobot", str(root), f"--{name}", "--out", str(tmp_path)]) == 0
    info = json.loads((tmp_path / "data_lerobot" / ID / "meta" / "info.json").read_text())
    key = {"state": "privileged.state", "objects": "objects"}[name]
    width = len(next(iter(find_folders(root)[0])).rows([name])[name][0])
    assert info["features"][key] == {"dtype": "float32", "shape": [width], "names": None}


def test_what_is_not_there_is_refused(collected, tmp_path, capsys):
    name, root = collected
    (other,) = set(ROWS) - {name}
    assert main(["rlds", str(root), f"--{other}", "--out", str(tmp_path)]) == 1
    assert f"`engram collect --{other}` writes them" in capsys.readouterr().err
    both = [*COLLECT, "--state", "--objects", "--out", str(tmp_path)]
    result = subprocess.run(both, capture_output=True, text=True)
    assert (result.returncode, result.stderr.split(";")[0]) == (
        2,
        "engram: --state excludes --objects",
    )
