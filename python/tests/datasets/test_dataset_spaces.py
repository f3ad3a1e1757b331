"""Sets of other control modes, and with joint angles, through every format."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from sound_dataset import ID, STEPS, arrays_of, metadata_text, sound_metadata

import engram
from engram.datasets import DatasetError, Episode, demonstration_writer, find_folders
from engram.datasets.readers import READERS
from engram.datasets.spaces import Spaces

pytest.importorskip("pyarrow")
pytest.importorskip("av")
pytest.importorskip("google_crc32c")

from engram.datasets import lerobot, rlds

JOINTS = Spaces("pd_joint_pos", True)
SOME = [
    Spaces(),
    Spaces("pd_ee_delta_pose", True),
    JOINTS,
    Spaces("pd_joint_delta_pos", False),
    Spaces("pd_joint_pos_vel", True),
    Spaces("pd_ee_target_delta_pos", False),
]


def episode(number: int, spaces: Spaces) -> Episode:
    arrays = arrays_of(number)
    rng = np.random.default_rng(number)
    action = rng.uniform(-1, 1, (STEPS, len(spaces.action_names))).astype(np.float32)
    action[:, : spaces.absolute] *= 2.8
    arrays["action"] = action
    arrays["proprio"] = rng.normal(size=(STEPS, len(spaces.proprio_names))).astype(np.float32)
    for name in ("language_instruction", "success_once", "episode_length", "episode_seed"):
        arrays[name] = arrays[name].item()
    return Episode(**arrays)


def write(root: Path, spaces: Spaces, count: int = 2) -> Path:
    for number in range(count):
        demonstration_writer.append_episode(
            root,
            ID,
            episode(number, spaces),
            player="a test",
            version=engram.__version__,
            spaces=spaces,
        )
    return root / "data_npz" / ID


@pytest.mark.parametrize("mode", sorted(engram.describe(ID)["action_spaces"]))
def test_names_are_as_many_as_the_numbers_of_an_action(mode):
    spaces = Spaces(mode)
    described = engram.describe(ID)["action_spaces"][mode]
    assert len(set(spaces.action_names)) == len(spaces.action_names) == described["dim"]
    beyond_one = [high != 1 for high in described["high"]]
    assert beyond_one == [i < spaces.absolute for i in range(described["dim"])]


@pytest.mark.parametrize("spaces", SOME, ids=str)
@pytest.mark.parametrize("layout", ["npz", "rlds", "3.0", "2.1"])
def test_every_format_returns_the_numbers(tmp_path, spaces, layout):
    write(tmp_path, spaces)
    (folder,) = find_folders(tmp_path)
    assert folder.spaces == spaces
    form = layout
    if layout == "rlds":
        rlds.convert(folder, tmp_path, jobs=1)
    elif layout != "npz":
        lerobot.convert(folder, tmp_path, version=layout, frames="images")
        form = "lerobot"
    stored = list(READERS[form](folder, tmp_path))
    assert len(stored) == 2
    for number, one in enumerate(stored):
        expected = episode(number, spaces)
        np.testing.assert_array_equal(one.action, expected.action)
        np.testing.assert_array_equal(one.rgb, expected.rgb)
        np.testing.assert_array_equal(one.proprio, spaces.proprio(expected.proprio, one.angles))
        assert (one.angles == "continuous") == (form == "lerobot")


@pytest.mark.parametrize("version", ["3.0", "2.1"])
def test_lerobot_names_joints(tmp_path, version):
    write(tmp_path, JOINTS)
    path = lerobot.convert(find_folders(tmp_path)[0], tmp_path, version=version, frames="images")
    features = json.loads((path / "meta" / "info.json").read_text())["features"]
    names = [*(f"joint{i}" for i in range(1, 8)), "gripper"]
    for key in ("observation.state", "action"):
        assert features[key] == {"dtype": "float32", "shape": [8], "names": names}


def test_a_mixture_is_refused_by_what_it_mixes(tmp_path):
    folder = write(tmp_path, JOINTS, 1)
    before = sorted(path.read_bytes() for path in folder.iterdir())
    wanted = "pd_joint_pos and proprio of joints, this is one of pd_ee_delta_pose and .* the TCP"
    with pytest.raises(DatasetError, match=wanted):
        write(tmp_path, Spaces(), 1)
    assert sorted(path.read_bytes() for path in folder.iterdir()) == before
    with pytest.raises(DatasetError, match="action: 7 numbers given; 8 needed for pd_joint_pos"):
        demonstration_writer.append_episode(
            tmp_path, ID, episode(1, Spaces()), player="a test", version="1", spaces=JOINTS
        )
    # A file of another set, moved into this one.
    np.savez(folder / "train_data_0.npz", **arrays_of(0))
    expected = r"proprio is .* \(3, 7\), .* \(3, 8\) expected in a set of pd_joint_pos and"
    with pytest.raises(DatasetError, match=expected):
        find_folders(tmp_path)[0][0]


def test_a_converted_set_of_other_demonstrations_is_refused(tmp_path):
    write(tmp_path, JOINTS)
    lerobot.convert(find_folders(tmp_path)[0], tmp_path / "out", frames="images")
    write(tmp_path / "out", Spaces("pd_joint_delta_pos", True))
    (folder,) = find_folders(tmp_path / "out")
    with pytest.raises(DatasetError, match=r"a set of pd_joint_pos .* are of pd_joint_delta_pos"):
        next(READERS["lerobot"](folder, tmp_path / "out"))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"control_mode": "pd_magic"}, "control_mode: 'pd_magic' given; pd_joint_delta_pos"),
        ({"control_mode": ["pd_joint_pos"]}, "control_mode"),
        ({"joint_proprio": "yes"}, "joint_proprio: 'yes' given; true or false needed"),
    ],
)
def test_metadata_of_no_control_mode_are_refused(tmp_path, change, words):
    folder = write(tmp_path, JOINTS)
    document = sound_metadata()
    document["engram"] |= change
    (folder / "metadata.json").write_text(metadata_text(document))
    with pytest.raises(DatasetError, match=words):
        find_folders(tmp_path)


def test_only_angles_may_be_beyond_one(tmp_path):
    file = write(tmp_path, JOINTS, 1) / "train_data_0.npz"
    assert np.abs(Episode.load(file, JOINTS).action[:, :7]).max() > 1
    with np.load(file) as stored:
        arrays = dict(stored)
    arrays["action"][1, 7] = 1.5  # of the gripper
    np.savez(file, **arrays)
    with pytest.raises(DatasetError, match=r"action: 1\.5 given; numbers in \[-1, 1\] needed"):
        Episode.load(file, JOINTS)
