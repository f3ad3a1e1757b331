"""engram_learners/clone.py: a recurrent student from a written data set alone."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from programs import TASK, learners, run, torch

import engram

COMMAND = [sys.executable, "-m", "engram"]
OPTIONS = ["--updates", "24", "--evaluate-every", "12", "--batch", "8", "--episodes", "3"]


@pytest.fixture(scope="module")
def demonstrations(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("demonstrations")
    command = [*COMMAND, "collect", TASK, "--episodes=20", "--out", str(out)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return out / "data_npz" / TASK


def train(demonstrations: Path, out: Path, *options: str) -> list[dict[str, Any]]:
    """The lines of a short training."""
    lines = run("clone", str(demonstrations), "--out", str(out), *OPTIONS, *options)
    assert lines == (out / "log.jsonl").read_text().splitlines()
    return [json.loads(line) for line in lines]


@pytest.fixture(scope="module")
def trained(
    demonstrations: Path, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, list[dict[str, Any]]]:
    out = tmp_path_factory.mktemp("clone")
    return out / "agent.pt", train(demonstrations, out)


def views(count: int = 3) -> tuple[Any, Any]:
    """Pictures (T, N, 64, 64, 3) and proprio (T, N, 7) of the oracle's episodes."""
    batch = engram.make_vec(TASK, count, obs_mode="rgb", threads=1, copy=True)
    seen, steps = batch.reset(seed=5)[0], []
    for _ in range(14):
        steps.append((seen["rgb"], seen["proprio"]))
        seen = batch.step(batch.act("oracle"))[0]
    batch.close()
    return tuple(np.stack(parts) for parts in zip(*steps))


@torch.no_grad()
def inputs(student: Any, rgb: Any, proprio: Any) -> list[Any]:
    """What the student gets (T, N, ...): positions and peaks of keypoints, the robot."""
    place, peak = student.see(learners.clone.downsample(rgb.reshape(-1, *rgb.shape[2:])))
    seen = [part.unflatten(0, rgb.shape[:2]) for part in (place, peak)]
    return [*seen, learners.clone.robot_features(proprio)]


def test_the_loss_falls_and_the_student_plays(trained: tuple[Path, list[dict[str, Any]]]) -> None:
    agent, lines = trained
    assert [line["updates"] for line in lines] == [12, 24]
    assert lines[1]["loss"] < 0.8 * lines[0]["loss"]
    assert lines[0]["cpu_s"] < lines[1]["cpu_s"]
    for row in (lines[1], lines[1]["wiped"]):
        low, high = row["interval"]
        assert low <= row["success_once"] <= high
    runner = learners.inference.load_runner(agent)
    assert (runner.task, runner.obs, runner.student.memory) == (TASK, "rgb", True)
    again = engram.evaluate(
        runner, TASK, episodes=3, seed=learners.clone.SEED, threads=1, num_envs=50
    )
    assert again["tasks"][0]["sr"] == lines[1]["success_once"]


def test_a_process_plays_it(trained: tuple[Path, list[dict[str, Any]]]) -> None:
    policy = f"{sys.executable} -m engram_learners.serve {trained[0]}"
    command = [*COMMAND, "eval", TASK, "--obs", "rgb", "--policy-command", policy, "--json"]
    command += ["--episodes", "2", "--threads", "1"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["tasks"][0]["n_episodes"] == 2


def test_the_control_has_no_memory(demonstrations: Path, tmp_path: Path) -> None:
    lines = train(demonstrations, tmp_path, "--no-memory")
    assert "wiped" not in lines[-1]
    control = learners.inference.load_runner(tmp_path / "agent.pt").student
    steps = inputs(control, *views())
    with torch.no_grad():
        whole, late = control(*steps)[0], control(*(part[9:] for part in steps))[0]
    np.testing.assert_allclose(whole.weights[9:], late.weights, atol=1e-5)


def test_steps_equal_a_whole_sequence(trained: tuple[Path, list[dict[str, Any]]]) -> None:
    student = learners.inference.load_runner(trained[0]).student
    steps = inputs(student, *views())
    with torch.no_grad():
        whole, state = student(*steps)[0], None
        for t in range(len(steps[0])):
            choice, state = student(*(part[t : t + 1] for part in steps), state)
            np.testing.assert_allclose(choice.weights[0], whole.weights[t], atol=1e-4)
            np.testing.assert_allclose(choice.mean[0], whole.mean[t], atol=1e-4)
        late = student(*(part[9:] for part in steps))[0]
    assert (late.weights[0] - whole.weights[9]).abs().max() > 1e-4  # it remembers


def test_a_wiped_memory_begins_with_the_view_that_is_acted_on(
    trained: tuple[Path, list[dict[str, Any]]],
) -> None:
    """Until the hand moves, every step is as an episode's first; then the memory is kept."""
    student = learners.inference.load_runner(trained[0]).student
    rgb, proprio = views()
    moved = np.abs(proprio[:, :, :3] - proprio[0, :, :3]).max(-1) > 1e-3
    moves = moved.argmax(0)
    assert (moves > 2).all()
    assert moved.any(0).all()
    wiped = learners.clone.StudentRunner(student, TASK, forget=True)
    answers = [
        wiped(
            {
                "rgb": rgb[t],
                "proprio": proprio[t],
                "worker": 0,
                "slot": range(3),
                "first": [t == 0] * 3,
            }
        )
        for t in range(len(rgb))
    ]
    for i, begin in enumerate(moves - 1):  # the last view before the hand has moved
        own = inputs(student, rgb[begin:, i : i + 1], proprio[begin:, i : i + 1])
        with torch.no_grad():
            expected = student(*own)[0].best()[:, 0]
        np.testing.assert_allclose([one[i] for one in answers[begin:]], expected, atol=1e-4)
