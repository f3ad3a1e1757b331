"""Depth and segmentation of demonstrations, as collected and in converted data sets."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from mapped_dataset import MAPS, NAMES, maps_of, write_mapped
from sound_dataset import ID, STEPS, write_sound

pytest.importorskip("pyarrow")
pytest.importorskip("av")
pytest.importorskip("google_crc32c")

import pyarrow.parquet as pq

import engram
from engram.datasets import DatasetError, find_folders
from engram.datasets.__main__ import main
from engram.datasets.episodes import find_metadata
from engram.datasets.readers import READERS

FORMATS = ["rlds", "lerobot"] + ["hdf5"] * (importlib.util.find_spec("h5py") is not None)
OPTIONS = [f"--{name}" for name in MAPS]
COLLECT = [sys.executable, "-m", "engram", "collect", ID, "--episodes", "2"]


@pytest.fixture(scope="module")
def collected(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("maps")
    command = [*COLLECT, *OPTIONS, "--threads", "2", "--num-envs", "2", "--out", str(folder)]
    subprocess.run(command, check=True, capture_output=True)
    return folder


def test_they_are_what_environments_show(collected):
    (folder,) = find_folders(collected)
    mode = "rgb+depth+segmentation"
    names = engram.describe(ID, obs_mode=mode)["segmentation_names"]
    env = engram.make(ID, obs_mode=mode)
    for episode in folder:
        observation, _ = env.reset(seed=episode.episode_seed)
        assert episode.segmentation_names == names
        for step, action in enumerate(episode.action):
            for name in ("rgb", *MAPS):
                np.testing.assert_array_equal(getattr(episode, name)[step], observation[name])
            observation, *_ = env.step(action)
        assert len(np.unique(episode.segmentation)) > 5
        assert episode.depth.max() > 1000
    env.close()


def test_all_else_is_as_without_them(collected, tmp_path):
    subprocess.run([*COLLECT, "--out", str(tmp_path)], check=True, capture_output=True)
    for file in sorted((tmp_path / "data_npz" / ID).glob("*.npz")):
        with np.load(file) as plain, np.load(collected / "data_npz" / ID / file.name) as mapped:
            assert set(mapped.files) - set(plain.files) == {*MAPS, "segmentation_names"}
            for name in plain.files:
                np.testing.assert_array_equal(plain[name], mapped[name])


@pytest.mark.parametrize("format", FORMATS)
def test_collected_sets_are_played_again(collected, tmp_path, format, capsys):
    assert main([format, str(collected), *OPTIONS, "--out", str(tmp_path)]) == 0
    assert main(["replay", str(tmp_path), "--format", format, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)[0]["equal"]


def test_replay_finds_another_pixel(tmp_path, collected, capsys):
    with np.load(collected / "data_npz" / ID / "train_data_1.npz") as file:
        arrays = dict(file)
    arrays["depth"][2, 5, 6, 1] += 1
    target = tmp_path / "data_npz" / ID
    target.mkdir(parents=True)
    for file in sorted((collected / "data_npz" / ID).iterdir()):
        (target / file.name).write_bytes(file.read_bytes())
    np.savez(target / "train_data_1.npz", **arrays)
    assert main(["replay", str(tmp_path), "--json"]) == 1
    assert json.loads(capsys.readouterr().out)[0]["different"] == {"1": ["depth of step 2"]}


@pytest.mark.parametrize("format", FORMATS)
@pytest.mark.parametrize("chosen", [MAPS, MAPS[:1], MAPS[1:]])
def test_formats_hold_what_is_asked_for(tmp_path, format, chosen):
    write_mapped(tmp_path)
    assert main([format, str(tmp_path), *(f"--{name}" for name in chosen)]) == 0
    (folder,) = find_metadata(tmp_path, format)
    episodes = list(READERS[format](folder, tmp_path))
    for number, episode in enumerate(episodes):
        for name in MAPS:
            values = getattr(episode, name)
            if name in chosen:
                np.testing.assert_array_equal(values, maps_of(number)[name])
            else:
                assert values is None
    (card,) = (tmp_path / f"data_{format}").rglob("README.md")
    for name in MAPS:
        assert (f" --{name}" in card.read_text().split("## Use")[0].split("python -m")[-2]) == (
            name in chosen
        )


def test_lerobot_names_what_they_are(tmp_path):
    write_mapped(tmp_path)
    assert main(["lerobot", str(tmp_path), "--images", *OPTIONS]) == 0
    root = tmp_path / "data_lerobot" / ID
    features = json.loads((root / "meta" / "info.json").read_text())["features"]
    stats = json.loads((root / "meta" / "stats.json").read_text())
    (table,) = (pq.read_table(path) for path in root.glob("data/*/*"))
    assert set(table.column_names) == set(features)
    for camera, index in (("top", 0), ("wrist", 1)):
        depth = f"observation.images.{camera}_depth"
        assert features[depth]["shape"] == [128, 128, 1]
        assert features[depth]["info"] == {"is_depth_map": True, "depth_unit": "mm"}
        segments = f"observation.images.{camera}_segmentation"
        assert features[segments]["info"]["segmentation_names"] == NAMES
        values = np.concatenate([maps_of(number)["depth"][..., index] for number in (0, 1)])
        assert stats[depth]["min"] == [[[values.min()]]]
        assert stats[depth]["max"] == [[[values.max()]]]
        assert stats[depth]["mean"][0][0][0] == pytest.approx(values.mean())
        assert stats[depth]["std"][0][0][0] == pytest.approx(values.std())


@pytest.mark.parametrize("format", FORMATS)
def test_sets_without_them_are_refused(tmp_path, format, capsys):
    write_sound(tmp_path)
    for name in MAPS:
        assert main([format, str(tmp_path), f"--{name}"]) == 1
        error = capsys.readouterr().err
        assert f"{name}: '" in error
        assert f"has none; `engram collect --{name}` writes them" in error
    assert [path.name for path in tmp_path.iterdir()] == ["data_npz"]


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("depth", np.zeros((STEPS, 128, 128, 2), np.int16), "depth is int16"),
        ("depth", np.zeros((STEPS, 128, 128), np.uint16), "depth is uint16 of shape"),
        ("depth", np.zeros((STEPS + 1, 128, 128, 2), np.uint16), "depth is uint16 of shape"),
        (
            "segmentation",
            np.full((STEPS, 128, 128, 2), 3, np.uint16),
            "segmentation: 3 given; of 3 names",
        ),
        ("segmentation_names", np.array(["a", "\x1b[2J", "c"]), "segmentation_names: .* control"),
        ("segmentation_names", np.array([1, 2, 3]), "segmentation_names is int64"),
    ],
)
def test_damaged_ones_are_refused(tmp_path, name, value, words):
    write_mapped(tmp_path, **{name: value})
    with pytest.raises(DatasetError, match=rf"train_data_1\.npz'.*{words}"):
        find_folders(tmp_path)[0][1]


@pytest.mark.parametrize("format", FORMATS)
def test_episodes_with_other_names_are_refused(tmp_path, format, capsys):
    write_mapped(tmp_path, segmentation_names=np.array([*NAMES, "another"]))
    assert main([format, str(tmp_path), "--segmentation"]) == 1
    assert "episodes have different ones" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["data_npz"]


def test_a_folder_goes_on_with_the_same(collected):
    before = {path: path.read_bytes() for path in (collected / "data_npz").rglob("*.npz")}
    for options in ([], OPTIONS[:1], OPTIONS[1:], [*OPTIONS, "--labels"]):
        done = subprocess.run(
            [*COLLECT, *options, "--out", str(collected)],
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 2
        assert "given; the same, or another folder, allowed" in done.stderr
    after = {path: path.read_bytes() for path in (collected / "data_npz").rglob("*.npz")}
    assert after == before


def test_a_hidden_object_has_no_pixel(tmp_path):
    """A ball is shown, then mugs come down over it."""
    shell_game = "ShellGameTouch-VLA-v0"
    command = [*COLLECT[:-3], shell_game, "--episodes", "2", "--segmentation"]
    subprocess.run([*command, "--out", str(tmp_path)], check=True, capture_output=True)
    (folder,) = find_folders(tmp_path)
    for episode in folder:
        number = {name: index for index, name in enumerate(episode.segmentation_names)}

        def in_view(name, seen=episode.segmentation, number=number):
            return (seen == number[name]).any(axis=(1, 2))  # of each step and camera

        mugs = in_view("mug_left")[:, 0]
        assert mugs.any()
        assert not mugs.all()
        assert in_view("red_ball")[~mugs].all()
        assert not in_view("red_ball")[mugs].any()
