"""engram_learners: students of other environments, and disturbed training episodes."""

from __future__ import annotations

import argparse
import json
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from programs import learners, refused, run, torch

import engram

pytest.importorskip("matplotlib")

COLOR3 = "RememberColor3-VLA-v0"
TIMED = "TimedTransferEasy-VLA-v0"
INTERCEPT = "InterceptSlow-VLA-v0"
TIME = {"observe_time": True}
LONGER = {"constants": {"CUE_PHASE_STEPS": [8, 9], "max_episode_steps": 31}}
SEEDS = 4242424242


def untrained(env: Any) -> Any:
    torch.manual_seed(3)
    policy = learners.policy.Policy(env.layout)
    policy.fit(env.reset(seed=1)[None])
    with torch.no_grad():
        for weight in policy.act.parameters():
            weight += 0.15 * torch.randn_like(weight)
    return policy


def saved(folder: Path, task: Any, options: dict[str, Any]) -> Path:
    """agent.pt of an untrained policy of that environment."""
    inputs = None
    if not isinstance(task, str):
        inputs = learners.several_tasks.TaskInputs.of(task, options=options)
    env = learners.training.ObjectsEnv(task, 4, inputs=inputs, options=options)
    path = folder / "agent.pt"
    learners.checkpoints.save_policy(untrained(env), path, task, options=options)
    return path


# --- options of the environment ---


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("observe_time", ("observe_time", True)),
        ("rules=original", ("rules", "original")),
        ('constants={"COLORS": 7}', ("constants", {"COLORS": 7})),
    ],
)
def test_options_are_words_or_json(text: str, expected: tuple[str, Any]) -> None:
    assert learners.env_options.option(text) == expected


def test_other_options_are_refused() -> None:
    with pytest.raises(argparse.ArgumentTypeError, match="'seed' given; observe_time"):
        learners.env_options.option("seed=3")


def test_the_time_is_that_of_the_batch() -> None:
    """A runner computes it from the steps that a request has, to the bit."""
    both = [
        engram.make_vec(TIMED, 3, obs_mode="objects", observe_time=on, threads=1, copy=True)
        for on in (False, True)
    ]
    time = learners.env_options.Time(TIME)
    rows, timed = (batch.reset(seed=5)[0] for batch in both)
    for step in range(20):
        given = time.add(TIMED, torch.from_numpy(rows), [step] * 3)
        np.testing.assert_array_equal(given, timed)
        actions = both[0].act("oracle")
        rows, timed = (batch.step(actions)[0] for batch in both)


@pytest.mark.parametrize("task", [TIMED, [TIMED, COLOR3]], ids=["one", "several"])
def test_a_student_with_the_time_is_evaluated_as_it_is_trained(tmp_path: Path, task: Any) -> None:
    path = saved(tmp_path, task, TIME)
    runner = learners.inference.load_runner(path)
    assert runner.options == TIME
    result = engram.evaluate(runner, TIMED, obs="objects", episodes=3, threads=1, num_envs=3)
    env = learners.training.ObjectsEnv(TIMED, 3, inputs=runner.inputs, options=TIME)
    rows, state, returns = env.reset(seed=SEEDS), None, 0.0
    for _ in range(env.horizon):
        with torch.no_grad():
            choice, _, state, _ = runner.policy(rows[None], state)
        rows, rewards = env.step(choice.best()[0])
        returns = returns + rewards.double().numpy()
    np.testing.assert_allclose(result["tasks"][0]["returns"], returns, rtol=0, atol=0.02)


def test_the_variant_of_a_student_is_evaluated(tmp_path: Path) -> None:
    path = saved(tmp_path, COLOR3, LONGER)
    lines = run("evaluate", str(path), "--episodes", "2", "--json", "--out", str(tmp_path))
    assert json.loads(lines[0])["options"] == LONGER
    [settings] = tmp_path.glob("**/settings.json")
    assert "CUE_PHASE_STEPS" in settings.read_text()


def test_record_plays_the_variant_of_a_student(tmp_path: Path) -> None:
    path = saved(tmp_path, COLOR3, LONGER | TIME)
    switches = run("serve", str(path), "--switches")[0]
    assert shlex.split(switches) == [
        "--set",
        "CUE_PHASE_STEPS=[8, 9]",
        "--set",
        "max_episode_steps=31",
    ]
    policy = shlex.join([sys.executable, "-m", "engram_learners.serve", str(path)])
    command = [sys.executable, "-m", "engram", "record", COLOR3, "--obs", "objects", "--json"]
    command += ["--policy-command", policy, *shlex.split(switches), "--camera", "base"]
    done = subprocess.run(
        [*command, "--size", "16", "--hold", "0,0", "--out", str(tmp_path / "film.gif")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["frames"] == 32


def test_a_policy_with_the_time_needs_the_option(tmp_path: Path) -> None:
    path = saved(tmp_path, TIMED, TIME)
    assert learners.checkpoints.load_policy(path, TIMED, TIME)[0].layout.agent == 26
    with pytest.raises(ValueError, match="a policy that does not fit"):
        learners.checkpoints.load_policy(path, TIMED)


def test_delays_are_those_of_the_variant() -> None:
    constants = {"EMPTY_PHASE_STEPS": [40, 60], "max_episode_steps": 120}
    delays = learners.long_episodes.Delays(COLOR3, {"constants": constants})
    assert delays.own["EMPTY_PHASE_STEPS"] == (40, 60)
    env = learners.training.ObjectsEnv(
        COLOR3, 2, constants=delays.widest(), options={"constants": constants}
    )
    assert env.horizon == 120


SHORT = ["--iterations", "1", "--updates", "2", "--envs", "16"]


def test_distilling_with_the_time(tmp_path: Path) -> None:
    arguments = ["--option", "observe_time", "--disturb", "0.5", *SHORT]
    result = json.loads(run("distil", *arguments, "--out", str(tmp_path))[-1])
    assert result["options"] == TIME
    assert result["disturb"] == 0.5
    assert learners.inference.load_runner(tmp_path / "agent.pt").options == TIME


def test_reinforcement_in_another_control_mode(tmp_path: Path) -> None:
    given = ["--id", "RememberColor3-v0", "--option", "control_mode=pd_ee_delta_pose"]
    short = ["--steps", "1000", "--envs", "16", "--out", str(tmp_path)]
    result = json.loads(run("ppo_recurrent", *given, *short)[-1])
    assert result["options"] == {"control_mode": "pd_ee_delta_pose"}
    runner = learners.inference.load_runner(tmp_path / "agent.pt")
    assert runner.options == result["options"]
    assert runner.policy.layout.actions == 7


def test_pictures_have_no_time() -> None:
    code, words = refused("distil", "--obs", "rgb", "--option", "observe_time")
    assert code == 2
    assert "observe_time: --obs objects needed" in words


# --- disturbed episodes ---


def test_a_share_of_the_episodes_is_disturbed_once() -> None:
    torch.manual_seed(0)
    horizons = torch.full((4000, 1), 60.0)
    disturbance = learners.disturbance.Disturbance(0.4, horizons, 7)
    actions = torch.full((4000, 7), 9.0)
    played = torch.stack([disturbance(t, actions) for t in range(60)])
    random = (played != 9).all(-1)
    assert ((played == 9).all(-1) == ~random).all()
    steps = random.sum(0)
    assert 0.37 < (steps > 0).float().mean() < 0.43
    assert steps.max() == 12
    begins = random.float().argmax(0)[steps > 0]
    assert (begins == 0).float().mean() > 0.45
    assert 35 < begins.max() < 42
    changes = (random[1:] != random[:-1]).sum(0)
    assert changes.max() == 2  # one piece each
    assert played[random].abs().max() <= 1


def test_the_oracle_goes_on_from_disturbed_states() -> None:
    """Disturbed steps are in the rows; labels are the oracle's actions there, and it succeeds."""
    torch.manual_seed(1)
    env = learners.training.ObjectsEnv(INTERCEPT, 64, seed=3)
    policy = untrained(env)
    collected = []
    for share in (0, 0.5):
        env.reset(seed=3)
        collected.append(learners.distil.collect(policy, env, first=True, disturb=share))
    (plain, _), (rows, labels) = collected
    way = (rows - plain)[..., env.layout.tcp].norm(dim=-1)
    assert 0.3 < (way.amax(0) > 0.04).float().mean() < 0.6  # by 2 cm
    assert env.infos["success_once"].mean() > 0.8
    # The oracle moves back: against what the disturbance has added.
    late = way[40:].amax(0) < 0.3 * way.amax(0)
    assert late[way.amax(0) > 0.1].float().mean() > 0.5
    assert labels.isfinite().all()


def test_without_disturbance_nothing_is_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """So the results of a seed are those of before."""

    def refused(*_: Any) -> None:
        raise AssertionError

    monkeypatch.setattr(learners.distil, "Disturbance", refused)
    env = learners.training.ObjectsEnv(COLOR3, 4, seed=3)
    learners.distil.collect(untrained(env), env, first=True)
