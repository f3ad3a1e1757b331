"""HDF5 data sets, read by h5py alone, and damaged ones."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

pytest.importorskip("h5py")

import h5py
import numpy as np
from labelled_dataset import (
    MEMORIES,
    PARAPHRASES,
    PLANS,
    PRIVILEGED,
    SUBTASKS,
    labels_of,
    said,
    write_labelled,
)
from mapped_dataset import MAPS, NAMES, maps_of, write_mapped
from sound_dataset import EPISODES, ID, STEPS, arrays_of, fit_checksums, write_sound

import engram
from engram.datasets.__main__ import main

FILE = f"data_hdf5/{ID}/demonstrations.hdf5"


def convert(root, *options):
    assert main(["hdf5", str(root), *options]) == 0
    return root / FILE


def test_h5py_reads_every_step(tmp_path):
    write_sound(tmp_path)
    with h5py.File(convert(tmp_path)) as file:
        data = file["data"]
        assert data.attrs["total"] == EPISODES * STEPS
        environment = json.loads(data.attrs["env_args"])
        assert environment["env_name"] == ID
        assert environment["env_version"] == engram.__version__
        assert list(data) == [f"demo_{number}" for number in range(EPISODES)]
        for number, demonstration in enumerate(data.values()):
            arrays = arrays_of(number)
            assert demonstration.attrs["num_samples"] == STEPS
            assert demonstration.attrs["episode_seed"] == number
            assert bool(demonstration.attrs["success"]) is True
            assert demonstration.attrs["language_instruction"] == "Touch the cube."
            names = {"obs", "actions", "rewards", "dones", "is_action_frozen"}
            assert set(demonstration) == names
            is_frozen = demonstration["is_action_frozen"]
            assert (is_frozen.dtype, is_frozen.shape, is_frozen[0]) == (np.bool_, (STEPS,), True)
            expected = {
                "obs/image": arrays["rgb"][..., :3],
                "obs/wrist_image": arrays["rgb"][..., 3:],
                "obs/proprio": arrays["proprio"],
                "actions": arrays["action"],
                "rewards": arrays["reward"],
                "dones": arrays["done"],
            }
            for name, values in expected.items():
                assert demonstration[name].dtype == values.dtype
                np.testing.assert_array_equal(demonstration[name][:], values)
            image = demonstration["obs/image"]
            assert (image.chunks, image.compression) == ((1, 128, 128, 3), "gzip")


def test_depth_and_segmentation(tmp_path):
    write_mapped(tmp_path)
    with h5py.File(convert(tmp_path, *(f"--{name}" for name in MAPS))) as file:
        assert list(file["data"].attrs["segmentation_names"]) == NAMES
        for number, demonstration in enumerate(file["data"].values()):
            for name in MAPS:
                for camera, key in enumerate((name, f"wrist_{name}")):
                    found = demonstration[f"obs/{key}"]
                    assert found.dtype == np.uint16
                    expected = maps_of(number)[name][..., camera, None]
                    np.testing.assert_array_equal(found[:], expected)


def test_labels(tmp_path):
    write_labelled(tmp_path)
    with h5py.File(convert(tmp_path, "--labels")) as file:
        for number, demonstration in enumerate(file["data"].values()):
            labels = demonstration["privileged"]
            for name in PRIVILEGED[:9]:
                assert labels[name].dtype == labels_of(number)[name].dtype
                np.testing.assert_array_equal(labels[name][:], labels_of(number)[name])
            for style, texts in (("subtask", SUBTASKS), ("plan", PLANS), ("memory", MEMORIES)):
                found = labels[style].asstr()[:].tolist()
                assert found == said(texts, number)
            wordings = demonstration["paraphrases"].asstr()[:].tolist()
            assert wordings == ["Touch the cube.", *PARAPHRASES]
    with h5py.File(convert(tmp_path)) as file:  # none unasked
        names: list[str] = []
        file.visit(names.append)
        assert not [name for name in names if "privileged" in name or "paraphrases" in name]
    card = (tmp_path / FILE).with_name("README.md").read_text()
    assert "privileged" not in card


def test_the_same_bytes_whatever_the_threads(tmp_path):
    write_mapped(tmp_path)
    options = [f"--{name}" for name in MAPS]
    first = convert(tmp_path, *options, "--jobs", "1").read_bytes()
    assert convert(tmp_path, *options, "--jobs", "3").read_bytes() == first


def test_collected_episodes_are_played_again(tmp_path):
    command = [sys.executable, "-m", "engram", "collect", ID, "--episodes", "2", "--depth"]
    command += ["--labels", "--format", "hdf5", "--out", str(tmp_path), "--json"]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    (result,) = json.loads(done.stdout)
    with h5py.File(tmp_path / FILE) as file:
        assert file["data"].attrs["total"] == result["steps"]
    assert main(["replay", str(tmp_path), "--format", "hdf5"]) == 0
    with h5py.File(tmp_path / FILE, "r+") as file:
        file["data/demo_1/rewards"][2] += 1
    assert main(["replay", str(tmp_path), "--format", "hdf5"]) == 1


def damage_type(demonstration):
    values = demonstration["actions"][:]
    del demonstration["actions"]
    demonstration["actions"] = values.astype(np.float64)


def damage_size(demonstration):
    del demonstration["obs/image"]
    demonstration.create_dataset("obs/image", (10**9, 128, 128, 3), np.uint8, chunks=True)


def damage_soft(demonstration):
    del demonstration["actions"]
    demonstration["actions"] = h5py.SoftLink("/data/demo_0/actions")


def damage_external(demonstration):
    del demonstration["obs"]
    demonstration["obs"] = h5py.ExternalLink("/etc/passwd", "/")


def damage_file(demonstration):
    del demonstration["rewards"]
    demonstration.create_dataset("rewards", (STEPS,), np.float32, external="/etc/passwd")


def damage_filter(demonstration, **storage):
    values = demonstration["rewards"][:]
    del demonstration["rewards"]
    demonstration.create_dataset("rewards", data=values, **storage)


def damage_lzf(demonstration):
    damage_filter(demonstration, compression="lzf")


def damage_shuffle(demonstration):
    damage_filter(demonstration, compression="gzip", shuffle=True)


def damage_fletcher32(demonstration):
    damage_filter(demonstration, compression="gzip", fletcher32=True)


def damage_chunks(demonstration):
    damage_filter(demonstration, compression="gzip", chunks=(10**6,), maxshape=(None,))


def damage_steps(demonstration):
    demonstration.attrs["num_samples"] = -1


def damage_whole(demonstration):
    del demonstration.file["data"]


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (damage_type, "actions is float64 of shape"),
        (damage_size, "obs/image is uint8 of shape"),
        (damage_soft, "actions is missing, or a link"),
        (damage_external, "obs is missing, or a link"),
        (damage_file, "rewards is not in the file itself"),
        (damage_lzf, "rewards is not in the file itself, or neither plain nor gzip"),
        (damage_shuffle, "rewards is not in the file itself, or neither plain nor gzip"),
        (damage_fletcher32, "rewards is not in the file itself, or neither plain nor gzip"),
        (damage_chunks, "rewards has chunks of (1000000,)"),
        (damage_steps, "num_samples: -1 given"),
        (damage_whole, "is missing, or a link"),
    ],
)
def test_damaged_files_are_refused(tmp_path, damage, words, capsys):
    write_sound(tmp_path)
    path = convert(tmp_path)
    with h5py.File(path, "r+") as file:
        damage(file["data/demo_0"])
    fit_checksums(tmp_path)
    capsys.readouterr()
    assert main(["replay", str(tmp_path), "--format", "hdf5"]) == 1
    error = capsys.readouterr().err
    assert error.startswith(f"engram.datasets: '{path}'")
    assert words in error
    assert error.count("\n") == 1


@pytest.mark.parametrize("size", [0, 100, 5000])
def test_a_file_that_was_cut_off(tmp_path, size, capsys):
    write_sound(tmp_path)
    path = convert(tmp_path)
    path.write_bytes(path.read_bytes()[:size])
    fit_checksums(tmp_path)
    capsys.readouterr()
    assert main(["replay", str(tmp_path), "--format", "hdf5"]) == 1
    assert "is damaged, or not engram's" in capsys.readouterr().err
