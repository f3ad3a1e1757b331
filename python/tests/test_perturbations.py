"""Perturbations through the Python API, results and data sets."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from demonstrations import COMMAND

import engram

TASK = "RememberColor3-VLA-v0"
AXES = ["camera", "fov", "light", "table", "floor", "distractors", "occluder", "noise", "blur"]
AXES += ["start_pose", "action_delay", "action_noise", "instruction"]


def first_pictures(**options) -> np.ndarray:
    env = engram.make_vec(TASK, num_envs=4, obs_mode="rgb", threads=1, **options)
    return env.reset(seed=3)[0]["rgb"].copy()


def test_each_axis_of_pictures_changes_them_in_every_episode() -> None:
    usual = first_pictures()
    for axis in AXES[:10]:
        changed = first_pictures(perturb={axis: 1.0})
        differing = (changed != usual).any(axis=(1, 2, 3))
        assert differing.all(), axis


def test_level_zero_and_none_are_the_usual_episodes() -> None:
    usual = first_pictures()
    assert np.array_equal(first_pictures(perturb=None), usual)
    assert np.array_equal(first_pictures(perturb=dict.fromkeys(AXES, 0)), usual)


def test_bad_axes_and_levels_are_refused() -> None:
    with pytest.raises(engram.UnknownIdError, match="'smell'; allowed are: camera, fov"):
        engram.make_vec(TASK, perturb={"smell": 1})
    with pytest.raises(engram.InvalidArgumentError, match="'light': level 2 given, 0 to 1"):
        engram.make_vec(TASK, perturb={"light": 2})
    with pytest.raises(engram.InvalidArgumentError, match="'light': level -1"):
        engram.evaluate(lambda _: None, TASK, episodes=1, perturb={"light": -1})


def test_perturbations_are_draws_that_are_described_and_pinned() -> None:
    env = engram.make_vec(TASK, num_envs=2, perturb={"start_pose": 0.5, "light": 0.5})
    draws = {draw["name"]: draw for draw in env.description["draws"]}
    assert draws["perturb_start_pose"]["width"] == 7
    assert "perturb_light" in draws
    assert "perturb_camera" not in draws
    pins = {"perturb_start_pose": [0, 0, 0, 0, 0, 0, 1], "robot_noise": [0] * 7}
    env.reset(seed=0, options={"pins": pins})
    assert env.robot_state()["qpos"][0, 6] == pytest.approx(np.pi / 4 + 0.12)


def test_other_wordings_reach_policies() -> None:
    seen: set[str] = set()

    def policy(observation):
        seen.update(observation["instruction"])
        return np.zeros((len(observation["instruction"]), 7), np.float32)

    engram.evaluate(policy, TASK, obs="state", episodes=30, perturb={"instruction": 1})
    assert len(seen) > 5


def test_results_name_the_levels() -> None:
    results = engram.evaluate(
        lambda o: np.zeros((len(o["instruction"]), 7), np.float32),
        TASK,
        obs="state",
        episodes=2,
        perturb={"light": 0.5, "blur": 0},
    )
    task = results["tasks"][0]
    assert task["perturbations"] == {"light": 0.5}
    assert task["memory_score"] is None


def test_groups_of_tasks_are_perturbed_as_each_task_is_alone() -> None:
    perturb = {"camera": 1, "start_pose": 1}
    other = "ShellGameTouch-VLA-v0"
    both = engram.make_vec({TASK: 2, other: 2}, obs_mode="rgb", perturb=perturb)
    rgb = both.reset(seed=5)[0]["rgb"]
    alone = engram.make_vec(other, num_envs=2, obs_mode="rgb", perturb=perturb)
    assert np.array_equal(rgb[2:], alone.reset(seed=5)[0]["rgb"])


def test_demonstrations_are_collected_and_replayed_with_their_perturbations(tmp_path: Path) -> None:
    levels = {"camera": 1.0, "start_pose": 1.0}
    words = [f"--perturb={axis}={level}" for axis, level in levels.items()]
    subprocess.run(
        [*COMMAND, "collect", TASK, "--episodes", "3", *words, "--out", tmp_path],
        check=True,
        capture_output=True,
    )
    folder = tmp_path / "data_npz" / TASK
    metadata = json.loads(next(folder.glob("*.json")).read_text())
    assert metadata["engram"]["perturbations"] == levels
    replay = ["-m", "engram.datasets", "replay", tmp_path]
    done = subprocess.run([sys.executable, *replay], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    refused = subprocess.run(
        [*COMMAND, "collect", TASK, "--episodes", "4", "--out", tmp_path],
        capture_output=True,
        text=True,
        check=False,
    )
    assert refused.returncode != 0
    assert "perturbations" in refused.stderr
