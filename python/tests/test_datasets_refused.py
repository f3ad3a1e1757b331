"""Data sets from others: what is refused, and that nothing is touched but the output folder."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import fuzz_datasets
import numpy as np
import pytest
from fuzz_datasets import tree
from sound_dataset import ID, arrays_of, metadata_text, sound_metadata, write_sound

from engram.datasets import DatasetError, DemonstrationFolder, find_folders

needs_libraries = pytest.mark.skipif(
    not fuzz_datasets.has_libraries(), reason="the libraries of data sets are missing"
)
CONVERTERS = {"rlds": Path("data_rlds") / ID / "1.0.0", "lerobot": Path("data_lerobot") / ID}


@pytest.fixture
def root(tmp_path) -> Path:
    """A valid data set, beside a folder that must not change."""
    (tmp_path / "outside").mkdir()
    (tmp_path / "outside" / "thesis.txt").write_text("the only copy")
    write_sound(tmp_path / "in")
    return tmp_path / "in"


def change_metadata(root: Path, **fields) -> None:
    path = root / "data_npz" / ID / "metadata.json"
    path.write_text(metadata_text(sound_metadata() | fields))


def change_array(root: Path, name: str, value) -> None:
    np.savez(root / "data_npz" / ID / "train_data_1.npz", **(arrays_of(1) | {name: value}))


def run(command: str, root: Path, *options: str) -> str:
    """Runs the command, which must fail, and change nothing; returns the sentence it says."""
    before = tree(root.parent)
    result = subprocess.run(
        [sys.executable, "-m", "engram.datasets", command, str(root), *options],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert result.returncode in (1, 2), result
    assert tree(root.parent) == before
    lines = result.stderr.splitlines()
    assert len(lines) == 1 or result.returncode == 2
    assert lines[-1].isprintable()
    return lines[-1]


# --- reading ---


def test_a_sound_folder_is_read(root):
    (folder,) = find_folders(root)
    assert [episode.episode_seed for episode in folder] == [0, 1]
    assert [len(episode) for episode in folder[0:2]] == [3, 3]
    np.testing.assert_array_equal(folder[-1].action, arrays_of(1)["action"])
    with pytest.raises(IndexError):
        folder[2]


@pytest.mark.parametrize(
    "name",
    [
        "../../outside",
        "/tmp/x-v0",
        "..",
        "",
        "a/b-v0",
        f"{ID}\0",
        f"{ID}\n",
        "\x1b[2Jx-v0",
        3,
        None,
    ],
)
def test_an_id_that_is_none_is_refused(root, name):
    change_metadata(root, env_id=name)
    with pytest.raises(DatasetError, match=r"env_id: .* an id needed") as refused:
        find_folders(root)
    assert str(refused.value).isprintable()


def test_an_id_that_is_not_its_folders_is_refused(root):
    change_metadata(root, env_id="RememberColor5-VLA-v0")
    with pytest.raises(DatasetError, match=f"the name of its folder needed, '{ID}'"):
        find_folders(root)


@pytest.mark.parametrize("count", [1e12, 10**12, -1, 0, "2", True, None, float("nan")])
def test_a_number_of_episodes_that_is_none_is_refused(root, count):
    change_metadata(root, num_episodes=count)
    with pytest.raises(DatasetError, match=r"num_episodes: .* a whole number from 1"):
        find_folders(root)


@pytest.mark.parametrize("name", ["episode_lengths", "episode_seeds"])
@pytest.mark.parametrize("values", [[1], [1, -1], [3, "3"], None, [[], []]])
def test_lists_that_do_not_fit_are_refused(root, name, values):
    change_metadata(root, **{name: values})
    with pytest.raises(DatasetError, match=name):
        find_folders(root)


@pytest.mark.parametrize("name", sorted(sound_metadata()))
def test_metadata_that_were_edited_are_refused(root, name):
    path = root / "data_npz" / ID / "metadata.json"
    good = path.read_text()
    document = json.loads(good)
    # Values that pass every other check.
    edits = {
        "env_id": ID.replace("3", "5"),
        "episode_seeds": [0, 2],
        "episode_lengths": [2, 3],
        "reward_sums": [9.5, 1.5],
        "num_episodes": 1,
        "engram": document["engram"] | {"rules": "original"},
    }
    document[name] = edits.get(name, "edited")
    path.write_text(json.dumps(document))
    with pytest.raises(DatasetError, match=r"metadata\.json.* checksum"):
        find_folders(root)
    path.write_text(good.replace(" ", "  "))  # the document counts, not its spaces
    assert len(find_folders(root)) == 1


@pytest.mark.parametrize("version", ["0.3.0", "99.0.0", None, 4])
def test_data_of_another_version_are_refused_by_its_name(root, version):
    change_metadata(root, engram=sound_metadata()["engram"] | {"version": version})
    with pytest.raises(DatasetError, match=f"of engram {version!r}, and this is engram"):
        find_folders(root)


def test_data_that_the_originals_scripts_collected_are_read(root):
    path = root / "data_npz" / ID / "metadata.json"
    document = json.loads(path.read_text())
    for name in ("engram", "checksum"):
        path.write_text(json.dumps({key: value for key, value in document.items() if key != name}))
        with pytest.raises(DatasetError, match=r"engram|checksum"):
            find_folders(root)
    del document["engram"], document["checksum"]
    path.write_text(json.dumps(document))
    (folder,) = find_folders(root)
    assert len(folder) == document["num_episodes"]


@pytest.mark.parametrize("content", [b"", b"[" * 100_000, b"\xff", b"[]", b"9" * 5000])
def test_metadata_that_is_none_is_refused(root, content):
    (root / "data_npz" / ID / "metadata.json").write_bytes(content)
    with pytest.raises(DatasetError, match=r"metadata\.json"):
        find_folders(root)


def test_a_pipe_is_not_waited_for(root):
    path = root / "data_npz" / ID / "metadata.json"
    path.unlink()
    os.mkfifo(path)
    with pytest.raises(DatasetError, match="no file"):
        find_folders(root)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("action", np.full((3, 7), np.nan, np.float32)),
        ("action", np.full((3, 7), 1.5, np.float32)),
        ("action", np.zeros((3, 6), np.float32)),
        ("action", np.zeros((3, 7), np.float64)),
        ("proprio", np.zeros((3, 6), np.float32)),
        ("proprio", np.full((3, 7), np.inf, np.float32)),
        ("reward", np.full(3, np.nan, np.float32)),
        ("reward", np.zeros((3, 1), np.float32)),
        ("success", np.ones(3, np.int32)),
        ("done", np.zeros(3, np.int32)),
        ("success_once", np.array(False)),
        ("rgb", np.zeros((3, 64, 64, 6), np.uint8)),
        ("rgb", np.zeros((2, 128, 128, 6), np.uint8)),
        ("episode_length", np.array([3, 3], np.int32)),
        ("episode_length", np.array(0, np.int32)),
        ("episode_length", np.array(2**31 - 1, np.int32)),
        ("episode_seed", np.array(-1, np.int64)),
        ("language_instruction", np.array("\x1b]0;x\x07")),
        ("language_instruction", np.array("x" * 50_000)),
        ("language_instruction", np.array(["two", "texts"])),
        ("language_instruction", np.array(None, object)),
    ],
)
def test_an_array_that_is_none_of_a_demonstration_is_refused(root, name, value):
    change_array(root, name, value)
    (folder,) = find_folders(root)
    with pytest.raises(DatasetError, match=rf"train_data_1\.npz'.*{name}") as refused:
        folder[1]
    assert str(refused.value).isprintable()


def test_episodes_are_those_in_metadata(root):
    change_metadata(root, episode_seeds=[0, 2])
    with pytest.raises(DatasetError, match=r"has seed 1; metadata\.json has 2"):
        DemonstrationFolder(root / "data_npz" / ID)[1]


def test_nothing_is_unpickled(root, tmp_path):
    touch = fuzz_datasets.Touch(tmp_path / "ran")
    change_array(root, "action", np.array(touch, object))
    with pytest.raises(DatasetError, match="action"):
        find_folders(root)[0][1]
    assert not (tmp_path / "ran").exists()


# --- writing ---


@needs_libraries
@pytest.mark.parametrize("command", CONVERTERS)
@pytest.mark.parametrize("up", ["../../outside", "../outside", "ABSOLUTE"])
def test_an_id_leads_nowhere(root, command, up):
    outside = root.parent / "outside"
    change_metadata(root, env_id=up.replace("ABSOLUTE", str(outside)))
    assert "an id needed" in run(command, root)


@needs_libraries
@pytest.mark.parametrize(
    ("command", "depth"),
    [(name, i + 1) for name, path in CONVERTERS.items() for i in range(len(path.parts))],
)
def test_links_are_not_followed(root, command, depth):
    link = root.joinpath(*CONVERTERS[command].parts[:depth])
    link.parent.mkdir(parents=True, exist_ok=True)
    link.symlink_to(root.parent / "outside")
    assert "is a link" in run(command, root)


@needs_libraries
@pytest.mark.parametrize("command", CONVERTERS)
def test_other_files_are_not_replaced(root, command):
    place = root / CONVERTERS[command]
    place.mkdir(parents=True)
    (place / "notes.txt").write_text("the only copy")
    assert "notes.txt' was not written by engram.datasets" in run(command, root)


@needs_libraries
@pytest.mark.parametrize("command", CONVERTERS)
def test_earlier_output_is_replaced(root, command, capsys):
    from engram.datasets.__main__ import main

    options = ["--images"] if command == "lerobot" else []
    assert main([command, str(root), *options]) == 0
    first = tree(root)
    place = root / CONVERTERS[command]
    for file in place.glob("[!.]*.json"):
        file.write_text("{}")  # left by a full disk
    assert main([command, str(root), *options]) == 0
    assert tree(root) == first
    (place / "notes.txt").write_text("added by a user")
    assert "notes.txt" in run(command, root, *options)


@needs_libraries
@pytest.mark.parametrize("command", CONVERTERS)
def test_no_partial_files_are_left(root, command):
    change_array(root, "action", np.full((3, 7), np.nan, np.float32))
    assert "not finite" in run(command, root)
    assert "not finite" in run(command, root, "--out", str(root.parent / "new" / "folder"))


@needs_libraries
def test_leftovers_are_removed_unless_a_process_still_writes(root):
    import fcntl

    from engram.datasets import rlds

    (folder,) = find_folders(root)
    parent = root / "data_rlds" / ID
    leftover = parent / "1.0.0.4242-0123abcd.engram-tmp"
    (leftover / "deep").mkdir(parents=True)
    holder = os.open(leftover, os.O_RDONLY)
    fcntl.flock(holder, fcntl.LOCK_EX)
    with pytest.raises(DatasetError, match="being written by process 4242"):
        rlds.convert(folder, root)
    os.close(holder)
    rlds.convert(folder, root)
    assert [path.name for path in parent.iterdir()] == ["1.0.0"]


@needs_libraries
@pytest.mark.parametrize(
    "arguments",
    [
        ["lerobot", "--fps", "0"],
        ["lerobot", "--fps", "-5"],
        ["lerobot", "--fps", "nan"],
        ["lerobot", "--modality", "gr00t"],
        ["lerobot", "--modality", "gr00t", "--version", "2.1", "--images"],
        ["lerobot", "--codec", ""],
        ["lerobot", "--codec", "no-such-codec"],
        ["lerobot", "--codec", "aac"],
        ["lerobot", "--codec", "gif"],
        ["lerobot", "--out", ""],
        ["rlds", "--jobs", "-1"],
        ["rlds", "--jobs", "99999999999999999999"],
        ["replay", "--episodes", "0"],
    ],
)
def test_options_out_of_range_are_refused(root, arguments):
    command, *options = arguments
    assert "given" in run(command, root, *options)


@needs_libraries
def test_options_of_the_functions_are_checked_too(root):
    from engram.datasets import lerobot, rlds

    (folder,) = find_folders(root)
    with pytest.raises(DatasetError, match="fps: 0 given"):
        lerobot.convert(folder, root, fps=0)
    with pytest.raises(DatasetError, match="jobs: -1 given"):
        rlds.convert(folder, root, jobs=-1)


@needs_libraries
@pytest.mark.parametrize("command", CONVERTERS)
def test_a_full_disk_is_told_with_the_path(root, command):
    before = tree(root.parent)
    # As many bytes as a disk has left.
    limited = "import resource, runpy; resource.setrlimit(resource.RLIMIT_FSIZE, (3000, 3000)); "
    options = ["--images"] if command == "lerobot" else []  # encoders print lines of their own
    limited += f"import sys; sys.argv[1:] = {[command, str(root), *options]!r}; "
    limited += "runpy.run_module('engram.datasets', run_name='__main__')"
    result = subprocess.run(
        [sys.executable, "-c", limited], capture_output=True, text=True, timeout=60, check=False
    )
    assert result.returncode == 1
    assert str(root / CONVERTERS[command]) in result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert tree(root.parent) == before


# --- the search ---


def test_a_slice_of_the_fuzzing_finds_nothing():
    counts, findings = fuzz_datasets.play(0, 120)
    assert not findings
    assert counts["refused"] > 60
    assert counts["accepted"] > 0
