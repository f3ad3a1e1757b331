"""engram_learners: instructions as inputs of a policy for several tasks."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from programs import learners, refused, run, torch

import engram

pytest.importorskip("matplotlib")

TOUCH, PUSH = "ShellGameTouch-VLA-v0", "ShellGamePush-VLA-v0"
COLOR, ROTATE = "RememberColor3-VLA-v0", "RotateLenientPos-VLA-v0"
SEED = 4242424242


def readers(ids: list[str]) -> tuple[Any, Any]:
    """Inputs with words, and an untrained policy that moves the robot and reads them."""
    inputs = learners.several_tasks.TaskInputs.of(ids, True, False)
    env = learners.training.ObjectsEnv(ids, 2 * len(ids), inputs=inputs)
    torch.manual_seed(3)
    policy = learners.policy.Policy(inputs.layout, appearances=12, hidden=32, width=48)
    policy.fit(env.reset(seed=1)[None])
    with torch.no_grad():
        for weight in policy.act.parameters():
            weight += 0.15 * torch.randn_like(weight)
    return inputs, policy


# --- words ---


def test_unknown_words_and_numbers_are_skipped() -> None:
    bag = learners.instructions.BagOfWords(["cube", "rotate", "the", "touch"])
    assert bag(["Touch the CUBE, touch the cube!", "Rotate by 40 degrees"]).tolist() == [
        [1, 0, 1, 1],
        [0, 1, 0, 0],
    ]
    assert not bag(["", "Bring tea"]).any()
    assert learners.instructions.words_of("Rotate by {angle_deg} degrees") == {
        "rotate",
        "by",
        "degrees",
    }
    encoder = learners.instructions.InstructionEncoder(4)
    assert encoder(bag(["", "Touch the cube"])).isfinite().all()


def test_every_task_of_the_split_has_wordings_that_are_held_out() -> None:
    ids = learners.several_tasks.short_split()
    assert len(ids) == 38
    tasks = [engram.describe(id, obs_mode="objects") for id in ids]
    words = set(learners.instructions.vocabulary(tasks))
    for task in tasks:
        trained = learners.instructions.trained(task["instruction"], task)
        unseen = task["paraphrases"][-learners.instructions.HELD_OUT :]
        assert len(trained) >= 9, task["id"]
        assert len(unseen) == 2, task["id"]
        assert not set(trained) & set(unseen), task["id"]
        assert learners.instructions.words_of(task["instruction"]) <= words
        for wording in unseen:  # most of it is known
            own = learners.instructions.words_of(wording)
            assert len(own & words) > 0.6 * len(own), wording


def test_training_draws_wordings_and_a_test_has_the_instruction() -> None:
    batch = engram.make_vec([TOUCH, ROTATE], 80, obs_mode="objects", threads=1)
    batch.reset(seed=5)
    torch.manual_seed(1)
    own, drawn = learners.instructions.own(batch), learners.instructions.drawn(batch)
    unseen = learners.instructions.held_out(batch)
    assert own == list(batch.instructions)
    assert len(set(drawn[:40])) == 9
    assert own[0] in drawn
    assert set(unseen[:40]) == set(batch.words()[0]["paraphrases"][-2:])
    assert not set(unseen) & {*drawn, *own}
    angle = own[79].split()[4]
    assert angle.isdigit()
    assert angle in drawn[79].split() + drawn[79].replace(",", " ").split()


# --- inputs ---


def test_the_rows_of_a_batch_and_of_one_task_have_the_same_words() -> None:
    ids = [TOUCH, PUSH, ROTATE]
    inputs = learners.several_tasks.TaskInputs.of(ids, True, False)
    env = learners.training.ObjectsEnv(ids, 6, inputs=inputs)
    rows = env.reset(seed=7)
    layout = env.layout
    bags = rows[:, layout.words_begin : layout.agent]
    assert bags.shape[1] == len(layout.words) > 30
    assert torch.equal(bags[0], bags[1])
    differ = [word for word, off in zip(layout.words, bags[0] != bags[2]) if off]
    assert differ == ["forward", "push", "touch"]
    for id in ids:
        one = learners.training.ObjectsEnv(id, 2, inputs=inputs)
        own = one.reset(seed=7)
        assert torch.equal(own, rows[env.parts[id], : own.shape[1]])
        assert not rows[env.parts[id], own.shape[1] :].any()
    assert torch.equal(env.step(env.oracle())[0][:, layout.words_begin : layout.agent], bags)


def test_number_words_or_both_tell_the_task() -> None:
    widths = {}
    for name, given in learners.several_tasks.TASK_INPUTS.items():
        layout = learners.several_tasks.TaskInputs.of([TOUCH, PUSH], *given).layout
        widths[name] = layout.agent - 25
        again = learners.several_tasks.TaskInputs.like([TOUCH, PUSH], layout).layout
        assert (again.agent, again.words) == (layout.agent, layout.words)
    assert widths["number"] == 2
    assert widths["both"] == 2 + widths["words"] > 30


# --- the policy ---


@torch.no_grad()
def test_a_policy_reads() -> None:
    """One observation with another instruction: another action. Unknown words: the same."""
    inputs, policy = readers([TOUCH, PUSH])
    batch = engram.make_vec(TOUCH, 2, obs_mode="objects", threads=1)
    rows = torch.from_numpy(batch.reset(seed=SEED)[0])
    touch, push = (engram.describe(id)["instruction"] for id in (TOUCH, PUSH))

    def action(*sentences: str) -> Any:
        return policy(inputs.of_task(TOUCH, rows, sentences)[None])[0].best()[0]

    assert torch.equal(action(touch, touch), action(touch, touch + " Quickly, please!"))
    changed = (action(touch, touch) - action(touch, push)).abs().amax(-1)
    assert changed[0] == 0
    assert changed[1] > 1e-3


@torch.no_grad()
def test_a_checkpoint_has_the_vocabulary(tmp_path: Path) -> None:
    ids, path = [COLOR, PUSH], tmp_path / "agent.pt"
    inputs, policy = readers(ids)
    learners.checkpoints.save_policy(policy, path, ids)
    runner = learners.inference.load_runner(path)
    assert runner.policy.layout.words == inputs.bag_of_words.words
    assert runner.policy.sizes == {
        "appearances": 12,
        "counts": 8,
        "hidden": 32,
        "width": 48,
        "path_points": 0,
    }
    rows = torch.from_numpy(engram.make_vec(COLOR, 2, obs_mode="objects").reset(seed=1)[0])
    sentences = ["Touch the cube", "Push that cup forward"]
    own = inputs.of_task(COLOR, rows, sentences)
    assert torch.equal(runner.inputs.of_task(COLOR, rows, sentences), own)
    for one, other in zip(policy(own[None])[0], runner.policy(own[None])[0]):
        assert torch.equal(one, other)


def test_an_evaluation_gives_the_instruction(tmp_path: Path) -> None:
    """As learners play: each task alone, another instruction, and a task that is not trained on."""
    ids, path = [TOUCH, PUSH], tmp_path / "agent.pt"
    inputs, policy = readers(ids)
    learners.checkpoints.save_policy(policy, path, ids)
    runner = learners.inference.load_runner(path)

    def returns(task: str, instruction: str | None = None) -> Any:
        runner.instruction = instruction
        options: Any = {"obs": "objects", "episodes": 3, "threads": 1, "num_envs": 50}
        return engram.evaluate(runner, task, **options)["tasks"][0]["returns"]

    def played(task: str, sentence: str) -> Any:
        env = learners.training.ObjectsEnv(
            task, 3, inputs=inputs, wording=lambda batch: [sentence] * batch.num_envs
        )
        rows, state, total = env.reset(seed=SEED), None, 0.0
        with torch.no_grad():
            for _ in range(env.horizon):
                choice, _, state, _ = policy(rows[None], state)
                rows, rewards = env.step(choice.best()[0])
                total = total + rewards.double().numpy()
        return total

    push = engram.describe(PUSH)["instruction"]
    expected = played(PUSH, push)
    np.testing.assert_allclose(returns(PUSH), expected, rtol=0, atol=0.02)
    np.testing.assert_allclose(returns(PUSH, "Touch"), played(PUSH, "Touch"), rtol=0, atol=0.02)
    assert np.abs(np.array(returns(PUSH, "Touch")) - expected).max() > 0.05
    other = engram.describe(COLOR)["instruction"]
    np.testing.assert_allclose(returns(COLOR), played(COLOR, other), rtol=0, atol=0.02)
    with pytest.raises(ValueError, match="4 objects at most, as in training"):
        inputs.of_task("RememberColor5-VLA-v0", torch.zeros(1, 235), ["Touch"])


# --- the script ---


BRIEF = ["--updates", "2", "--envs", "8", "--evaluate-every", "1", "--episodes", "2"]


def test_a_run_that_is_cut_off_is_continued(tmp_path: Path) -> None:
    options = ["--id", TOUCH, PUSH, "--task-input", "words", *BRIEF, "--out", str(tmp_path)]
    command = [sys.executable, "-m", "engram_learners.distil", *options, "--iterations", "1000"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as cut_off:
        assert cut_off.stdout
        before = [json.loads(cut_off.stdout.readline()) for _ in range(2)]
        cut_off.kill()
    lines = run("distil", *options, "--iterations", "4", "--resume")
    printed = [json.loads(line) for line in lines]
    assert printed[-2]["env_steps"] == 4 * 8 * 30 == 2 * before[1]["env_steps"]
    assert [row["cpu_s"] > before[1]["cpu_s"] for row in printed[-3:-1]] == [True, True]
    assert printed[-1]["held_out"]["tasks"].keys() == {TOUCH, PUSH}
    assert len((tmp_path / "log.csv").read_text().splitlines()) == 1 + 4
    assert sorted(path.name for path in tmp_path.glob("*.p*t")) == ["agent.pt"]
    other = ["--id", PUSH, "--instruction", "Touch that cup.", "--episodes", "2", "--json"]
    assert json.loads(run("evaluate", str(tmp_path / "agent.pt"), *other)[0])["id"] == PUSH


def test_an_instruction_is_refused_by_a_policy_that_reads_none(tmp_path: Path) -> None:
    layout = learners.several_tasks.TaskInputs.of([TOUCH, PUSH]).layout
    policy = learners.policy.Policy(layout)
    learners.checkpoints.save_policy(policy, tmp_path / "agent.pt", [TOUCH, PUSH])
    agent = str(tmp_path / "agent.pt")
    code, words = refused("evaluate", agent, "--instruction", "Touch that cup.")
    assert code == 1
    assert "this policy reads none" in words
