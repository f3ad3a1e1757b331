"""engram_learners: labels of the memory's loss, the policy, and runs of the learners."""

from __future__ import annotations

import csv
import importlib.util
import json
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from programs import learners, run, torch

pytest.importorskip("matplotlib")

LAMP = "ShellGameShuffleColorLampTouch-VLA-v0"
COLOR3 = "RememberColor3-VLA-v0"
JOINTS = "RememberColor3-v0"  # actions move joints


def episodes(task: str, num_envs: int = 8, steps: int | None = None) -> tuple[Any, Any]:
    """Rows (T, N, D) of the oracle's episodes, and their layout."""
    env = learners.training.ObjectsEnv(task, num_envs, 3, steps)
    rows = [env.reset(seed=3)]
    for _ in range(env.horizon - 1):
        rows.append(env.step(env.oracle())[0])
    return torch.stack(rows), env.layout


def fitted(rows: Any, layout: Any, memory: bool = True, **sizes: int) -> Any:
    torch.manual_seed(0)
    policy = learners.policy.Policy(layout, memory=memory, **sizes)
    policy.fit(rows)
    return policy


# --- labels of the memory's loss ---


def test_labels_have_the_appearance_that_the_cue_showed() -> None:
    rows, layout = episodes(COLOR3)
    policy = fitted(rows, layout)
    shown, _, _ = learners.memory_loss.MemoryLoss.labels(policy, rows)
    tokens = layout.split(rows)[1]
    of_cue = policy.code(layout.pairs(tokens))[0].amax(-2)
    assert (of_cue.sum(-1) == 1).all()
    assert (shown[:, :, 0] == of_cue).all()  # in all steps, whatever is in layout
    last = shown[-1, :, 1]
    assert (last == of_cue).all()  # the other colours are in layout, but were not before
    assert (shown[0, :, 1] == 0).all()  # nothing was before the first view


def test_labels_track_an_object_under_a_moving_cup() -> None:
    """At the end the cup that the oracle touches hides the colour that the lamp shows."""
    rows, layout = episodes(LAMP)
    policy = fitted(rows, layout)
    of_objects = learners.memory_loss.MemoryLoss.labels(policy, rows)[2]
    tokens = layout.split(rows)[1][-1]
    hidden = of_objects[-1, ..., : learners.policy.N_APPEARANCES] @ policy.colors()
    lamp = tokens[..., layout.part["kind"]].argmax(-1) == 8
    shown = tokens[lamp][..., layout.part["color"]]
    cups = tokens[..., layout.part["kind"]].argmax(-1) == 2
    near = (tokens[..., layout.place] - rows[-1, :, None, layout.tcp])[..., :2].norm(dim=-1)
    touched = near.masked_fill(~cups, 9).argmin(-1)
    under = hidden[torch.arange(len(touched)), touched]
    assert (under == shown).all()
    assert (hidden[cups].sum(-1) == 1).all()  # every cup hides one ball


@pytest.mark.parametrize(
    ("task", "sizes", "most"),
    [
        ("BlinkCountButtonPressEasy-VLA-v0", {}, 7),
        ("BlinkCountButtonPressMedium-Long-VLA-v0", {}, 7),
        ("BlinkCountButtonPressMedium-Long-VLA-v0", {"counts": 12}, 11),
    ],
)
def test_labels_count_the_changes_of_a_lamp(task: str, sizes: dict[str, int], most: int) -> None:
    rows, layout = episodes(task, 16)
    policy = fitted(rows, layout, **sizes)
    counts = learners.memory_loss.MemoryLoss.labels(policy, rows)[2][
        ..., learners.policy.N_APPEARANCES :
    ]
    tokens = layout.split(rows)[1]
    lamps = tokens[0, ..., layout.lamp] > 0
    lit = tokens[..., layout.part["state"]][..., 0] > 0.5
    rises = (lit[1:] & ~lit[:-1]).sum(0)[lamps]
    assert rises.amax() >= (10 if "Long" in task else 2)
    assert (counts[-1][lamps].argmax(-1) == rises.clamp(max=most)).all()
    assert policy(rows[:2])[1][2].shape[-1] == counts.shape[-1] + learners.policy.N_APPEARANCES


def presses(reach: float) -> tuple[Any, Any, Any, dict[str, Any]]:
    """Oracle's episodes of BlinkCount with vertical motion scaled by `reach`.

    -> of the counting button: depth (T, N), number of presses (T, N), label that the tool has to be
    lifted (T, N); and the engine's infos of the same, by name.
    """
    env = learners.training.ObjectsEnv("BlinkCountButtonPressEasy-VLA-v0", 32, 3)
    rows, infos = [env.reset(seed=3)], {"raw_press_count": [], "pending_press": []}
    for _ in range(env.horizon - 1):
        action = env.oracle()
        action[:, 2] *= reach
        rows.append(env.step(action)[0])
        for name, steps in infos.items():
            steps.append(torch.from_numpy(np.array(env.infos[name])))
    rows, layout = torch.stack(rows), env.layout
    tokens = layout.split(rows)[1]
    red = (tokens[0, ..., layout.part["color"]][..., 0] > 0) & (tokens[0, ..., layout.button] > 0)
    known = learners.memory_loss.MemoryLoss.labels(fitted(rows, layout), rows)[2][1:, red]
    depth = tokens[1:, red][..., layout.part["state"]][..., 0]
    counts = known[..., learners.policy.N_APPEARANCES : -1].argmax(-1)
    return depth, counts, known[..., -1], {k: torch.stack(v) for k, v in infos.items()}


def test_labels_count_shallow_presses() -> None:
    """A press counts from 0.35 of the depth on."""
    depth, counts, _, infos = presses(0.6)
    assert (depth.amax(0) < 0.5).sum() > 5  # or nothing is tested
    assert counts[-1].amax() == 3
    assert (counts[-1] == infos["raw_press_count"][-1]).all()


def test_labels_of_a_button_change_when_the_tool_is_lifted() -> None:
    """A press counts when the tool is up again. Until then the button is held to be touched."""
    _, counts, touched, infos = presses(1.0)
    assert counts[-1].amax() == 3
    assert (touched == infos["pending_press"].float()).all()


def test_an_object_in_the_place_of_another_begins_a_view() -> None:
    """Every cube of the cue has a view of its own, even if it gets the token of the one before."""
    env = learners.training.ObjectsEnv("ChainOfColors3-VLA-v0", 128, 3)
    rows = [env.reset(seed=3)]
    for _ in range(15):  # the longest cue, and a step after it
        rows.append(env.step(torch.zeros(128, 7))[0])
    rows = torch.stack(rows)
    layout, tokens = env.layout, env.layout.split(rows)[1]
    seen, pairs = tokens[..., 0] > 0, layout.pairs(tokens)
    in_place = (seen[1:] == seen[:-1]).all(-1) & (pairs[1:] != pairs[:-1]).any(-1)
    assert in_place.any()  # or nothing is tested
    policy = fitted(rows, layout)
    first = learners.memory_loss.MemoryLoss.labels(policy, rows)[0][-1, :, 2]
    views = learners.policy.N_VIEWS * first
    button = policy.code(pairs[0])[tokens[0, ..., layout.button] > 0]
    views = views.masked_fill(button > 0, 9).sort(-1).values
    assert (views[:, :3] == torch.arange(3)).all()


def test_labels_keep_touched_objects() -> None:
    rows, layout = episodes("BunchOfColors3-VLA-v0", steps=100)
    policy = fitted(rows, layout)
    tokens = layout.split(rows)[1]
    touched = learners.memory_loss.MemoryLoss.labels(policy, rows)[2][-1, ..., -1] > 0
    cue = policy.code(layout.pairs(tokens))[0].amax(-2)  # three cubes to touch, and the button
    touched_appearances = (policy.code(layout.pairs(tokens))[-1] * touched[..., None]).amax(-2)
    assert (touched.sum(-1) == 3).all()
    assert (touched_appearances <= cue).all()


# --- the policy ---


@pytest.mark.parametrize("memory", [True, False])
def test_single_steps_equal_a_whole_sequence(memory: bool) -> None:
    rows, layout = episodes(LAMP, 4)
    policy = fitted(rows, layout, memory)
    with torch.no_grad():
        whole = policy(rows)[0]
        state = None
        for t, row in enumerate(rows):
            choice, _, state, _ = policy(row[None], state)
            np.testing.assert_allclose(choice.mean[0], whole.mean[t], atol=1e-5)
            np.testing.assert_allclose(choice.weights[0], whole.weights[t], atol=1e-4)


def test_only_a_memory_distinguishes_equal_observations() -> None:
    rows, layout = episodes(COLOR3)
    late = rows.clone()
    late[10:] = rows[10:, :1]  # the same observation for all, after different cues
    for memory in (True, False):
        with torch.no_grad():
            mean = fitted(rows, layout, memory)(late)[0].best()[10:]
        assert (mean == mean[:, :1]).all().item() != memory


def test_a_reset_memory_is_that_of_a_new_episode() -> None:
    rows, layout = episodes(COLOR3, 4)
    policy = fitted(rows, layout)
    which = torch.tensor([True, False, True, False])
    with torch.no_grad():
        state = policy(rows[:12])[2]
        wiped = policy(rows[12:13], policy.reset_state(state, which))[0].mean[0]
        fresh = policy(rows[12:13])[0].mean[0]
        kept = policy(rows[12:13], state)[0].mean[0]
    assert torch.equal(wiped[which], fresh[which])
    assert torch.equal(wiped[~which], kept[~which])
    assert not torch.equal(fresh, kept)


def test_actions_are_those_for_the_object_of_most_weight() -> None:
    weights = torch.log(torch.tensor([[[0.2, 0.5, 0.3]]]))
    mean = torch.arange(3.0)[None, None, :, None].expand(1, 1, 3, 7) - 0.5
    choice = learners.policy.Choice(weights, mean, torch.zeros_like(mean))
    assert (choice.best() == 0.5).all()
    np.testing.assert_allclose(choice.mixed()[0], 0.6, atol=1e-6)


def test_an_untrained_policy_moves_to_the_chosen_object() -> None:
    rows, layout = episodes(COLOR3)
    with torch.no_grad():
        choice = fitted(rows, layout)(rows)[0]
    seen = layout.split(rows)[1][..., 0] > 0
    toward, mean = layout.to_top(rows)[seen], choice.mean[..., :3][seen]
    far = toward.abs() > 0.3
    assert (mean.sign() == toward.sign())[far].all()
    assert (mean.abs() > 0.9)[far].all()


def test_an_untrained_policy_of_joints_rests() -> None:
    """The way to an object is no motion of joints."""
    rows, layout = episodes(JOINTS, steps=20)
    with torch.no_grad():
        choice = fitted(rows, layout)(rows)[0]
    assert choice.mean.shape[-1] == 8
    assert choice.mean.abs().max() < 0.1


def test_an_untrained_policy_without_memory_chooses_the_nearest_object() -> None:
    """It does not stay between objects."""
    rows, layout = episodes(COLOR3)
    with torch.no_grad():
        weights = fitted(rows, layout, memory=False)(rows)[0].weights
    agent, tokens = layout.split(rows)
    away = (tokens[..., layout.place] - agent[..., None, layout.tcp])[..., :2].norm(dim=-1)
    ordered, which = away.masked_fill(tokens[..., 0] == 0, 9).sort(-1)
    clear = (ordered[..., 1] - ordered[..., 0] > 0.1) & (tokens[..., 0].sum(-1) == 3)  # by 0.05 m
    assert clear.sum() > 10
    assert (weights.argmax(-1) == which[..., 0])[clear].all()


# --- distillation ---


def test_the_oracle_guides_the_first_episodes_and_half_of_the_others() -> None:
    env = learners.training.ObjectsEnv(COLOR3, 64, seed=3)
    policy = fitted(*episodes(COLOR3), memory=False)
    env.reset(seed=3)
    learners.distil.collect(policy, env, first=True)
    assert env.infos["success_once"].all()
    torch.manual_seed(1)
    learners.distil.collect(policy, env, first=False)
    assert 0.05 < env.infos["success_once"].mean() < 0.6


def test_attention_learns_the_object_of_the_oracle() -> None:
    weights = torch.zeros(2, requires_grad=True)
    mean = torch.stack([torch.zeros(7), torch.ones(7)])[None, None].requires_grad_()
    choice = learners.policy.Choice(weights.log_softmax(-1)[None, None], mean, mean)
    learners.distil.imitation(choice, torch.full((1, 1, 7), 0.9)).sum().backward()
    assert weights.grad[1] < -0.01 < 0.01 < weights.grad[0]
    assert mean.grad[0, 0, 1].abs().min() > 1e-2 > 1e-4 > mean.grad[0, 0, 0].abs().max()


# --- reinforcement learning ---


def test_advantages_equal_their_definition() -> None:
    generator = torch.Generator().manual_seed(1)
    rewards = torch.rand(9, 3, generator=generator)
    values = torch.rand(9, 3, generator=generator)
    args = SimpleNamespace(gamma=0.8, gae=0.7)
    after = torch.cat([values[1:], torch.zeros(1, 3)])
    errors = rewards + 0.8 * after - values
    expected = [sum((0.56**k) * errors[t + k] for k in range(9 - t)) for t in range(9)]
    np.testing.assert_allclose(
        learners.ppo_recurrent.estimate_advantages(rewards, values, args),
        torch.stack(expected),
        rtol=1e-5,
    )


# --- learners ---


DISTIL = ["distil", "--iterations", "2", "--updates", "4", "--evaluate-every", "1", "--episodes=8"]
PPO = ["--steps", "1600", "--evaluate-every", "1"]


@pytest.mark.parametrize(
    "command",
    [
        [*DISTIL, "--envs", "32"],
        pytest.param([*DISTIL, "--envs", "16", "--no-memory"], marks=pytest.mark.long),
        [*DISTIL, "--envs", "16", "--obs", "rgb", "--detector-updates", "3"],
        ["ppo_recurrent", *PPO, "--envs", "32"],
        ["ppo_recurrent", "--no-memory", *PPO, "--envs", "32"],
    ],
    ids=["distil", "distil_no_memory", "distil_rgb", "ppo_recurrent", "memoryless"],
)
def test_a_learner_runs_and_resumes(tmp_path: Path, command: list[str]) -> None:
    lines = run(*command, "--out", str(tmp_path))
    result = json.loads(lines[-1])
    assert result == json.loads((tmp_path / "result.json").read_text())
    assert 0 <= result["success_once"] <= 1
    remembers = "--no-memory" not in command
    assert ("wiped" in result) == remembers
    with (tmp_path / "log.csv").open(newline="") as file:
        assert len(list(csv.DictReader(file))) == 2
    assert (tmp_path / "curve.png").stat().st_size > 0
    logged = list(tmp_path.glob("events.out.tfevents.*"))
    assert logged or not importlib.util.find_spec("tensorboard")
    policy, detector, task = learners.checkpoints.load_policy(tmp_path / "agent.pt")
    assert (policy.memory, detector is not None, task) == (remembers, "rgb" in command, COLOR3)
    run(*command, "--out", str(tmp_path), "--resume")


def test_distilling_learns(tmp_path: Path) -> None:
    """A few seconds of training exceed the rate without memory (0.33)."""
    arguments = ["--iterations", "4", "--evaluate-every", "4", "--out", str(tmp_path)]
    result = json.loads(run("distil", *arguments)[-1])
    assert result["success_once"] > 0.8
    assert result["wiped"]["success_once"] < 0.6


@pytest.mark.long
def test_reinforcement_learns_to_use_the_memory(tmp_path: Path) -> None:
    """Half of the default steps exceed the rate without memory (0.33)."""
    arguments = ["--steps", "96000", "--evaluate-every", "1000", "--out", str(tmp_path)]
    result = json.loads(run("ppo_recurrent", *arguments)[-1])
    assert result["success_once"] > 0.6
    assert result["wiped"]["success_once"] < 0.5


@pytest.mark.long
def test_reinforcement_learns_with_memory_alone(tmp_path: Path) -> None:
    """Two thirds of the default steps of ppo_recurrent.py; without memory the policy guesses."""
    arguments = ["--steps", "130000", "--evaluate-every", "1000", "--out", str(tmp_path)]
    result = json.loads(run("ppo_recurrent", *arguments)[-1])
    assert result["success_once"] > 0.8
    assert result["wiped"]["success_once"] < 0.6
    control = json.loads(run("ppo_recurrent", "--no-memory", *arguments)[-1])
    assert control["first_answer_correct"] < 0.5


def test_data_parallel_training() -> None:
    command = [sys.executable, "-m", "torch.distributed.run", "--nproc-per-node", "2"]
    script = ["-m", "engram_learners.ppo_recurrent", "--envs", "32"]
    script += ["--steps", "1600", "--evaluate-every", "1000"]
    done = subprocess.run([*command, *script], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    results = [line for line in done.stdout.splitlines() if '"learner"' in line]
    assert len(results) == 1  # of the first process
