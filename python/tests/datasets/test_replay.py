"""Demonstrations played again, from every format."""

from __future__ import annotations

import json
import shutil
import subprocess

import numpy as np
import pytest
from demonstrations import COMMAND, EPISODES, IDS

from engram.datasets.__main__ import main


@pytest.mark.parametrize("format_name", ["npz", "rlds", "lerobot"])
def test_actions_played_again_show_the_same(demonstrations, format_name, capsys):
    assert main(["replay", str(demonstrations), "--format", format_name, "--json"]) == 0
    results = json.loads(capsys.readouterr().out)
    assert {result["env_id"] for result in results} == set(IDS)
    for result in results:
        assert result["equal"], result
        assert result["episodes"] == EPISODES
        assert result["steps"] > 2 * 9


@pytest.mark.parametrize("angles", ["continuous", "benchmark"])
@pytest.mark.parametrize("version", ["3.0", "2.1"])
def test_lerobot_sets_of_images_show_the_same(demonstrations, version, angles, tmp_path, capsys):
    (tmp_path / "data_npz").symlink_to(demonstrations / "data_npz")
    words = [str(tmp_path), IDS[-1]]
    options = ["--images", "--version", version, "--angles", angles]
    assert main(["lerobot", *words, *options]) == 0
    assert main(["replay", *words, "--format", "lerobot", "--json"]) == 0
    (result,) = json.loads(capsys.readouterr().out)
    assert (result["equal"], result["episodes"]) == (True, EPISODES)


# The lamp game draws what goes where unless the original's rules fix it.
def test_replay_follows_the_rules_of_the_data(tmp_path, capsys):
    task = "ShellGameColorLampTouch-VLA-v0"
    command = [*COMMAND, "collect", task, "--episodes=2", "--rules=original", "--out", tmp_path]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    metadata = json.loads((tmp_path / "data_npz" / task / "metadata.json").read_text())
    assert metadata["engram"]["rules"] == "original"
    assert main(["replay", str(tmp_path), "--json"]) == 0
    (result,) = json.loads(capsys.readouterr().out)
    assert result["equal"], result


def test_replay_follows_changed_constants(tmp_path, capsys):
    command = [*COMMAND, "collect", IDS[0], "--episodes=2", "--set", "CUE_PHASE_STEPS=4"]
    subprocess.run([*command, "--out", tmp_path], check=True, stdout=subprocess.DEVNULL)
    assert main(["replay", str(tmp_path), "--json"]) == 0
    (result,) = json.loads(capsys.readouterr().out)
    assert result["equal"], result


def test_a_changed_action_is_noticed(demonstrations, tmp_path, capsys):
    target = tmp_path / "data_npz" / IDS[0]
    shutil.copytree(demonstrations / "data_npz" / IDS[0], target)
    file = target / "train_data_1.npz"
    with np.load(file) as stored:
        arrays = dict(stored)
    arrays["action"][-3, 0] += 0.25
    np.savez(file, **arrays)
    assert main(["replay", str(tmp_path), "--json"]) == 1
    (result,) = json.loads(capsys.readouterr().out)
    assert list(result["different"]) == ["1"]
    assert any("proprio" in text for text in result["different"]["1"])
