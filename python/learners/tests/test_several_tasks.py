"""engram_learners: one policy for several tasks, its inputs, training and inference."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from programs import ROOT, find_objects, learners, refused, run, torch

import engram

pytest.importorskip("matplotlib")

COLOR, SHAPE, CUPS = "RememberColor3-VLA-v0", "RememberShape5-VLA-v0", "ShellGameTouch-VLA-v0"
INTERCEPT, ROTATE = "InterceptSlow-VLA-v0", "RotateLenientPos-VLA-v0"
SEED = 4242424242


def untrained(env: Any) -> Any:
    """A policy whose weights are large enough to move the robot and to depend on the task."""
    torch.manual_seed(3)
    policy = learners.policy.Policy(env.layout, appearances=12)
    policy.fit(env.reset(seed=1)[None])
    with torch.no_grad():
        for weight in policy.act.parameters():
            weight += 0.15 * torch.randn_like(weight)
    return policy


# --- inputs ---


def test_rows_of_one_task_have_the_places_of_the_common_layout() -> None:
    """Equal to a batch of all: robot, task, and objects, also with Rotate's task cue."""
    ids = [COLOR, CUPS, ROTATE]
    env = learners.training.ObjectsEnv(ids, 6)
    together = [env.reset(seed=7)]
    for _ in range(12):
        together.append(env.step(env.oracle())[0])
    inputs = learners.several_tasks.TaskInputs.of(ids)
    assert env.layout.agent == 26 + 3
    assert together[0].shape[1] == env.layout.agent + 4 * env.layout.width
    for number, id in enumerate(ids):
        alone = engram.make_vec(id, 2, obs_mode="objects")
        rows = [alone.reset(seed=7)[0]]
        for _ in range(12):
            rows.append(alone.step(alone.act("oracle").clip(-1, 1))[0])
        for row, all_rows in zip(rows, together):
            own = inputs.of_task(id, torch.from_numpy(row))
            assert torch.equal(own, all_rows[env.parts[id]])
        tasks = own[:, inputs.robot : inputs.robot + 3]
        assert tasks.tolist() == [[float(k == number) for k in range(3)]] * 2
        positions = env.layout.split(own)[1][..., env.layout.place].numpy()
        fields = {field["name"]: field for field in alone.description["state_fields"]}
        at = fields["object_0_position"]["offset"]
        assert (positions[:, 0] == rows[-1][:, at : at + 3]).all()
        at = fields["tcp_pose"]["offset"]
        assert (own[:, env.layout.tcp].numpy() == rows[-1][:, at : at + 3]).all()


def test_the_cue_of_one_task_is_zero_in_another() -> None:
    env = learners.training.ObjectsEnv([COLOR, ROTATE], 4)
    fields = {field["name"]: field for field in env.batch.description["state_fields"]}
    cue = env.reset(seed=7)[:, fields["task_cue"]["offset"]]
    assert (cue != 0).tolist() == [False, False, True, True]


def test_other_tasks_and_observations_are_refused() -> None:
    inputs = learners.several_tasks.TaskInputs.of([COLOR, CUPS])
    with pytest.raises(ValueError, match=f"{SHAPE} given; tasks of this policy: {COLOR}, {CUPS}"):
        inputs.of_task(SHAPE, torch.zeros(2, 235))
    with pytest.raises(ValueError, match=f"35 numbers given, 151 needed: obs objects of {COLOR}"):
        inputs.of_task(COLOR, torch.zeros(2, 35))


def test_each_of_the_ten_tasks_can_be_learnt_alone() -> None:
    """By the scores of students of one task."""
    ten = learners.several_tasks.TEN
    assert len(set(ten)) == 10
    with (ROOT / "docs" / "data" / "scores.csv").open(newline="") as file:
        runs = list(csv.DictReader(file))
    for id in ten:
        alone = [run for run in runs if (run["id"], run["learner"]) == (id, "distilled")]
        assert np.mean([float(run["success_once"]) for run in alone]) > 0.9, id
        assert engram.describe(id)["horizon"] <= 60


# --- training ---


@pytest.fixture(scope="module")
def collected() -> tuple[Any, Any, Any, Any]:
    """Scenes of three horizons, a policy, and the oracle's rows and actions."""
    env = learners.training.ObjectsEnv([COLOR, CUPS, INTERCEPT], 9, 3)
    policy = untrained(env)
    env.reset(seed=3)
    rows, actions = learners.distil.collect(policy, env, first=True)
    return env, policy, rows, actions


def test_episodes_end_with_their_own_horizon(collected: tuple[Any, Any, Any, Any]) -> None:
    """What comes after an episode's end is neither trained on nor counted."""
    env, policy, rows, actions = collected
    assert env.horizon == 60 == len(rows)
    episodes = learners.distil.by_length(policy, env, rows, actions)
    assert [len(rows) for rows, *_ in episodes] == [25, 30, 60]
    for k, parts in enumerate(episodes):
        assert all(part.shape[:2] == (parts[0].shape[0], 3) for part in parts)
        own = rows[: len(parts[0]), 3 * k : 3 * k + 3]
        width = parts[0].shape[-1]  # up to the last object that the task has
        assert width == env.layout.agent + (3, 4, 2)[k] * env.layout.width
        assert torch.equal(parts[0], own[..., :width])
        assert not own[..., width:].any()
        assert torch.equal(parts[1], actions[: len(parts[0]), 3 * k : 3 * k + 3])
    spoiled = rows.clone()
    spoiled[25:, :3], spoiled[30:, 3:6] = 1e6, -1e6
    again = learners.distil.by_length(policy, env, spoiled, actions)
    for parts, others in zip(episodes, again):
        assert all(torch.equal(a, b) for a, b in zip(parts, others))


@torch.no_grad()
def test_objects_that_a_task_lacks_change_nothing(collected: tuple[Any, Any, Any, Any]) -> None:
    env, policy, rows, actions = collected
    for own, *_ in learners.distil.by_length(policy, env, rows, actions):
        padded = torch.nn.functional.pad(own, (0, rows.shape[-1] - own.shape[-1]))
        choices = [policy(given)[0] for given in (own, padded)]
        best = [choice.best() for choice in choices]
        torch.testing.assert_close(best[0], best[1], rtol=0, atol=1e-4)


def test_success_lasts_until_the_longest_episode_ends(collected: tuple[Any, Any, Any, Any]) -> None:
    env, _, rows, _ = collected
    tasks = {id: learners.training.rates(env.infos, part) for id, part in env.parts.items()}
    right = {"success_once": 1.0, "first_answer_correct": 1.0}
    assert tasks == {COLOR: right, CUPS: right, INTERCEPT: {**right, "first_answer_correct": None}}
    assert learners.training.means(tasks) == {**right, "least_success_once": 1.0}
    assert (rows[30:, :3] == rows[29:30, :3]).all()  # ended after 25 steps: it stands still


def test_tasks_have_equal_weight(collected: tuple[Any, Any, Any, Any]) -> None:
    """The logged loss is the mean of the tasks' own, though their episodes differ in length."""
    env, policy, rows, actions = collected
    episodes = learners.distil.by_length(policy, env, rows, actions)
    for length in episodes:  # any pick of equal episodes is the same
        for part in length:
            part[:] = part[:, :1].clone()
    with torch.no_grad():
        own = [learners.distil.losses_of(policy, *length)[0].item() for length in episodes]
    args = SimpleNamespace(updates=1, batch=600, recall=1.0, huber=0.3)
    still = SimpleNamespace(zero_grad=policy.zero_grad, step=lambda: None)
    logged = learners.distil.learn(policy, still, [episodes], args)
    assert np.ptp(own) > 0.01
    assert logged["action"] == pytest.approx(np.mean(own), abs=2e-4)


# --- inference ---


@torch.no_grad()
def lockstep(policy: Any, env: Any) -> np.ndarray:
    """Returns (N,) of all episodes at once, as learners play them."""
    rows, state, returns = env.reset(seed=SEED), None, 0.0
    for _ in range(env.horizon):
        choice, _, state, _ = policy(rows[None], state)
        rows, rewards = env.step(choice.best()[0])
        returns = returns + rewards.double().numpy()
    return returns


def test_an_evaluation_plays_every_task_as_learners_do(tmp_path: Path) -> None:
    ids, path = [COLOR, SHAPE], tmp_path / "agent.pt"
    env = learners.training.ObjectsEnv(ids, 8)
    policy = untrained(env)
    expected = lockstep(policy, env)
    assert np.ptp(expected) > 0.5  # the episodes differ
    learners.checkpoints.save_policy(policy, path, ids)
    runner = learners.inference.PolicyRunner.load(path)
    assert runner.task == ids
    assert runner.policy.appearances == 12
    result = engram.evaluate(runner, ids, obs="objects", episodes=4, threads=1, num_envs=50)
    returns = {task["env_id"]: task["returns"] for task in result["tasks"]}
    assert set(returns) == set(ids)
    for id in ids:
        # Torch's last bits depend on the size of a batch, and contacts magnify them.
        np.testing.assert_allclose(returns[id], expected[env.parts[id]], rtol=0, atol=0.02)


# --- pictures ---


@pytest.fixture
def pictures() -> Any:
    """Scenes of two horizons, with a detector that finds some objects."""
    torch.manual_seed(1)
    inputs = learners.several_tasks.TaskInputs.of([COLOR, CUPS], words=True, numbered=True)
    env = learners.images.rgb_env.RgbEnv([COLOR, CUPS], 6, seed=3, inputs=inputs)
    find_objects(env.detector)
    return env


def test_rows_from_pictures_have_robot_task_and_objects(pictures: Any) -> None:
    """Objects are those of the labels, in tokens of the detector; and each task's own words."""
    rows = pictures.reset(seed=3)
    robot, words = learners.images.views.ROBOT, len(pictures.layout.words)
    agent, tokens = pictures.layout.split(rows)
    assert agent.shape == (6, robot + 2 + words)
    assert agent[:, robot : robot + 2].tolist() == [[1, 0]] * 3 + [[0, 1]] * 3
    bags = agent[:, robot + 2 :]
    assert bags.sum(-1).min() >= 3
    assert (bags[0] == bags[1]).all()
    assert (bags[0] != bags[3]).any()
    assert tokens.shape[1] == len(pictures.detector.tokens)
    alone = learners.training.ObjectsEnv(CUPS, 3)
    alone.reset(seed=3)
    for _ in range(12):
        pictures.step(pictures.oracle())
        objects = alone.step(alone.oracle())[0]
    shown = pictures.layout.split(pictures.truth)[1][3:]
    expected = alone.layout.split(objects)[1]
    place = alone.layout.place
    for own, others in zip(shown, expected):
        own, others = own[own[:, 0] > 0][:, place], others[others[:, 0] > 0][:, place]
        assert len(own) == len(others)
        assert torch.cdist(own, others).amin(-1).max() < 0.05  # noise: 4 mm


def test_frames_of_ended_episodes_are_no_examples(pictures: Any) -> None:
    pictures.reset(seed=3)
    for _ in range(27):
        pictures.step(pictures.oracle())  # RememberColor3 has ended after 25 steps
    for _ in range(60):
        pictures.store()
    kept = pictures.frames.parts[0]
    of_ended, of_others = pictures.last[0][:3], pictures.last[0][3:]
    assert any(torch.equal(one, frame) for one in of_others for frame in kept)
    assert not any(torch.equal(one, frame) for one in of_ended for frame in kept)


def test_students_from_pictures_train_on_the_objects_of_each_task(pictures: Any) -> None:
    """Tokens that a task never shows are left out; the others are as they were."""
    policy = untrained(pictures)
    pictures.reset(seed=3)
    rows, actions = learners.distil.collect(policy, pictures, first=True)
    episodes = learners.distil.by_length(policy, pictures, rows, actions)
    layout, shown = pictures.layout, pictures.layout.split(rows)[1]
    for k, (own, labels, *_) in enumerate(episodes):
        part = slice(3 * k, 3 * k + 3)
        steps, tokens = (25, 3) if k == 0 else (30, 4)  # cubes; cups and a ball
        assert own.shape == (steps, 3, layout.agent + tokens * layout.width)
        assert torch.equal(labels, actions[:steps, part])
        agent, kept = layout.split(own)
        assert torch.equal(agent, rows[:steps, part, : layout.agent])
        seen = shown[:steps, part, :, 0] > 0
        assert torch.equal(kept[kept[..., 0] > 0], shown[:steps, part][seen])
    assert layout.tokens > 4


def test_an_evaluation_from_pictures_plays_every_task_as_learners_do(
    pictures: Any, tmp_path: Path
) -> None:
    policy, path = untrained(pictures), tmp_path / "agent.pt"
    learners.checkpoints.save_policy(policy, path, [COLOR, CUPS], pictures.detector)
    runner = learners.inference.PolicyRunner.load(path)
    assert (runner.obs, runner.task) == ("rgb", [COLOR, CUPS])
    options = {"obs": "rgb", "episodes": 3, "threads": 1, "num_envs": 50}
    result = engram.evaluate(runner, runner.task, **options)
    together = pictures.reset(seed=SEED)
    given = {"detector": pictures.detector, "inputs": pictures.inputs}
    for task in result["tasks"]:
        alone = learners.images.rgb_env.RgbEnv(task["env_id"], 3, **given)
        rows = together[pictures.parts[task["env_id"]]]
        np.testing.assert_allclose(alone.reset(seed=SEED), rows, atol=1e-4)
        expected = lockstep(policy, alone)
        assert (alone.found.known >= 0).any()
        assert np.ptp(expected) > 0.1  # the episodes differ
        np.testing.assert_allclose(task["returns"], expected, rtol=0, atol=1e-3)


# --- scripts ---


BRIEF = ["--iterations", "2", "--updates", "2", "--envs", "16", "--evaluate-every", "2"]


@pytest.mark.parametrize("obs", ["objects", pytest.param("rgb", marks=pytest.mark.long)])
def test_one_policy_is_distilled_and_played(obs: str, tmp_path: Path) -> None:
    ids = [COLOR, CUPS]
    options = [*BRIEF, "--appearances", "9", "--obs", obs, "--out", str(tmp_path)]
    result = json.loads(run("distil", "--id", *ids, *options)[-1])
    assert result == json.loads((tmp_path / "result.json").read_text())
    assert result["id"] == ids
    assert list(result["tasks"]) == list(result["wiped"]["tasks"]) == ids
    success = [one["success_once"] for one in result["tasks"].values()]
    assert result["success_once"] == pytest.approx(np.mean(success))
    assert result["least_success_once"] == min(success)
    with (tmp_path / "log.csv").open(newline="") as file:
        lines = list(csv.DictReader(file))
    assert [int(line["env_steps"]) for line in lines] == [2 * 8 * (25 + 30)]
    assert 0 <= float(lines[0][f"{COLOR} first_answer_correct"]) <= 1
    assert 0 <= float(lines[0][f"{CUPS} success_once"]) <= 1
    assert (tmp_path / "curve.png").stat().st_size > 0

    agent = tmp_path / "agent.pt"
    figures = run("evaluate", str(agent), "--episodes", "2", "--json")
    assert [json.loads(line)["id"] for line in figures] == ids
    command = [sys.executable, "-m", "engram", "eval", *ids, "--obs", obs, "--json"]
    served = f"{sys.executable} -m engram_learners.serve {agent}"
    short = ["--episodes", "2", "--threads", "1", "--num-envs", "50", "--policy-command", served]
    done = subprocess.run([*command, *short], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    rates = {one["id"]: one["policy"]["success_once"] for one in map(json.loads, figures)}
    assert {one["env_id"]: one["sr"] for one in json.loads(done.stdout)["tasks"]} == rates


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--id", COLOR, CUPS, "--obs", "rgb", "--chunk", "5"], "--chunk: one --id needed"),
        (["--id", COLOR, COLOR], "an id is given twice"),
        (["--id", COLOR, "--huber", "0"], "--huber: 0.0 given, more than 0 allowed"),
    ],
)
def test_bad_options_are_refused(options: list[str], message: str) -> None:
    code, words = refused("distil", *options)
    assert code == 2
    assert message in words


@pytest.mark.long
def test_one_policy_learns_opposite_rules(tmp_path: Path) -> None:
    """The colour that was shown, and the one that was not; without memory the rate is 0.33."""
    ids = [COLOR, "FindImposterColor3-VLA-v0", CUPS]
    options = ["--iterations", "6", "--evaluate-every", "6", "--out", str(tmp_path)]
    result = json.loads(run("distil", "--id", *ids, *options)[-1])
    assert result["least_success_once"] > 0.8
    assert result["wiped"]["success_once"] < 0.6
