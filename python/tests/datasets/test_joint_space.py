"""Demonstrations in joint space, collected, converted and played again."""

from __future__ import annotations

import json
import subprocess

import pytest
from demonstrations import COMMAND

pytest.importorskip("pyarrow")
pytest.importorskip("av")
pytest.importorskip("google_crc32c")

from engram.datasets import find_folders
from engram.datasets.__main__ import main

IDS = ("RememberColor3-VLA-v0", "InterceptSlow-VLA-v0")


@pytest.fixture(scope="module", params=["pd_joint_pos", "pd_joint_delta_pos"])
def joint_space(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("joints")
    command = [*COMMAND, "collect", *IDS, "--episodes=2", "--control-mode", request.param]
    subprocess.run(
        [*command, "--joint-proprio", "--out", folder], check=True, stdout=subprocess.DEVNULL
    )
    assert main(["rlds", str(folder)]) == 0
    return request.param, folder


def test_its_arrays_are_as_wide_as_the_mode_is(joint_space):
    mode, folder = joint_space
    for found in find_folders(folder):
        assert (found.spaces.control_mode, found.spaces.joint_proprio) == (mode, True)
        for episode in found:
            assert episode.action.shape == episode.proprio.shape == (len(episode), 8)
            assert 0 <= episode.proprio[:, 7].min() <= episode.proprio[:, 7].max() < 0.09


@pytest.mark.parametrize("layout", ["npz", "rlds", "3.0", "2.1"])
def test_it_is_played_again_to_the_same_success(joint_space, layout, capsys):
    _, folder = joint_space
    form = layout
    if "." in layout:
        assert main(["lerobot", str(folder), "--images", "--version", layout]) == 0
        form = "lerobot"
    assert main(["replay", str(folder), "--format", form, "--json"]) == 0
    results = json.loads(capsys.readouterr().out)
    assert [(result["env_id"], result["equal"]) for result in results] == [
        (id, True) for id in sorted(IDS)
    ]
