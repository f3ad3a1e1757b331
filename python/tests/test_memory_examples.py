"""python/examples/memory: what the memory is taught, that it is kept, and that the learners run."""

from __future__ import annotations

import csv
import importlib.util
import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

torch = pytest.importorskip("torch")
pytest.importorskip("matplotlib")

EXAMPLES = Path(__file__).parents[1] / "examples" / "memory"
LAMP = "ShellGameShuffleColorLampTouch-VLA-v0"
COLOR3 = "RememberColor3-VLA-v0"


@pytest.fixture(scope="module")
def learners() -> Iterator[SimpleNamespace]:
    sys.path.insert(0, str(EXAMPLES))
    try:
        import distil
        import eye
        import pictures
        import play
        import policy
        import ppo_recurrent

        yield SimpleNamespace(
            distil=distil,
            eye=eye,
            pictures=pictures,
            play=play,
            policy=policy,
            ppo=ppo_recurrent,
        )
    finally:
        sys.path.remove(str(EXAMPLES))


def episodes(
    learners: SimpleNamespace, task: str, num_envs: int = 8, steps: int | None = None
) -> tuple[Any, Any]:
    """Rows (T, N, D) of the oracle's episodes, and what they are cut up by."""
    scenes = learners.play.Objects(task, num_envs, 3, steps)
    rows = [scenes.reset(seed=3)]
    for _ in range(scenes.horizon - 1):
        rows.append(scenes.step(scenes.oracle())[0])
    return torch.stack(rows), scenes.sight


def fitted(learners: SimpleNamespace, rows: Any, sight: Any, memory: bool = True) -> Any:
    torch.manual_seed(0)
    policy = learners.policy.Policy(sight, memory=memory)
    policy.fit(rows)
    return policy


# --- what the memory is taught ---


def test_recollection_names_the_look_that_the_cue_showed(learners: SimpleNamespace) -> None:
    rows, sight = episodes(learners, COLOR3)
    policy = fitted(learners, rows, sight)
    shown, _, _ = learners.policy.Recollection.labels(policy, rows)
    tokens = sight.split(rows)[1]
    of_cue = policy.code(sight.pairs(tokens))[0].amax(-2)
    assert (of_cue.sum(-1) == 1).all()
    assert (shown[:, :, 0] == of_cue).all()  # in all steps, whatever is in sight
    last = shown[-1, :, 1]
    assert (last == of_cue).all()  # the other colours are in sight, but were not before
    assert (shown[0, :, 1] == 0).all()  # nothing was before the first view


def test_recollection_follows_what_stands_under_a_moving_cup(learners: SimpleNamespace) -> None:
    """At the end the cup that the oracle touches hides the colour that the lamp shows."""
    rows, sight = episodes(learners, LAMP)
    policy = fitted(learners, rows, sight)
    of_objects = learners.policy.Recollection.labels(policy, rows)[2]
    tokens = sight.split(rows)[1][-1]
    hidden = of_objects[-1, ..., : learners.policy.LOOKS] @ policy.colors()
    lamp = tokens[..., sight.part["kind"]].argmax(-1) == 8
    shown = tokens[lamp][..., sight.part["color"]]
    cups = tokens[..., sight.part["kind"]].argmax(-1) == 2
    near = (tokens[..., sight.place] - rows[-1, :, None, sight.tcp])[..., :2].norm(dim=-1)
    touched = near.masked_fill(~cups, 9).argmin(-1)
    under = hidden[torch.arange(len(touched)), touched]
    assert (under == shown).all()
    assert (hidden[cups].sum(-1) == 1).all()  # every cup hides one ball


def test_recollection_counts_what_a_lamp_did(learners: SimpleNamespace) -> None:
    task = "BlinkCountButtonPressEasy-VLA-v0"
    rows, sight = episodes(learners, task)
    policy = fitted(learners, rows, sight)
    counts = learners.policy.Recollection.labels(policy, rows)[2][..., learners.policy.LOOKS :]
    tokens = sight.split(rows)[1]
    lamps = tokens[0, ..., sight.lamp] > 0
    lit = tokens[..., sight.part["state"]][..., 0] > 0.5
    rises = (lit[1:] & ~lit[:-1]).sum(0)[lamps]
    assert rises.amax() >= 2
    assert (counts[-1][lamps].argmax(-1) == rises).all()


def presses(learners: SimpleNamespace, reach: float) -> tuple[Any, Any, Any, dict[str, Any]]:
    """The oracle's episodes of BlinkCount, who comes down and goes up by that share of the way.

    -> of the counting button: how far it was pressed (T, N), how often (T, N), whether the tool has
    to be lifted (T, N); and the engine's infos of the same, by name.
    """
    scenes = learners.play.Objects("BlinkCountButtonPressEasy-VLA-v0", 32, 3)
    rows, infos = [scenes.reset(seed=3)], {"raw_press_count": [], "pending_press": []}
    for _ in range(scenes.horizon - 1):
        action = scenes.oracle()
        action[:, 2] *= reach
        rows.append(scenes.step(action)[0])
        for name, steps in infos.items():
            steps.append(torch.from_numpy(np.array(scenes.infos[name])))
    rows, sight = torch.stack(rows), scenes.sight
    tokens = sight.split(rows)[1]
    red = (tokens[0, ..., sight.part["color"]][..., 0] > 0) & (tokens[0, ..., sight.button] > 0)
    known = learners.policy.Recollection.labels(fitted(learners, rows, sight), rows)[2][1:, red]
    depth = tokens[1:, red][..., sight.part["state"]][..., 0]
    counts = known[..., learners.policy.LOOKS : -1].argmax(-1)
    return depth, counts, known[..., -1], {k: torch.stack(v) for k, v in infos.items()}


def test_recollection_counts_shallow_presses(learners: SimpleNamespace) -> None:
    """A button takes it for a press when its cap is down by 0.35 of the way."""
    depth, counts, _, infos = presses(learners, 0.6)
    assert (depth.amax(0) < 0.5).sum() > 5  # or nothing is tested
    assert counts[-1].amax() == 3
    assert (counts[-1] == infos["raw_press_count"][-1]).all()


def test_recollection_knows_that_a_press_has_to_be_lifted(learners: SimpleNamespace) -> None:
    """A press counts when the tool is up again. Until then the button is held to be touched."""
    _, counts, touched, infos = presses(learners, 1.0)
    assert counts[-1].amax() == 3
    assert (touched == infos["pending_press"].float()).all()


def test_what_takes_the_place_of_another_comes_into_sight(learners: SimpleNamespace) -> None:
    """Every cube of the cue has a view of its own, even if it gets the token of the one before."""
    scenes = learners.play.Objects("ChainOfColors3-VLA-v0", 128, 3)
    rows = [scenes.reset(seed=3)]
    for _ in range(15):  # the longest cue, and a step after it
        rows.append(scenes.step(torch.zeros(128, 7))[0])
    rows = torch.stack(rows)
    sight, tokens = scenes.sight, scenes.sight.split(rows)[1]
    seen, pairs = tokens[..., 0] > 0, sight.pairs(tokens)
    in_place = (seen[1:] == seen[:-1]).all(-1) & (pairs[1:] != pairs[:-1]).any(-1)
    assert in_place.any()  # or nothing is tested
    policy = fitted(learners, rows, sight)
    first = learners.policy.Recollection.labels(policy, rows)[0][-1, :, 2]
    views = learners.policy.Recollection.VIEWS * first
    button = policy.code(pairs[0])[tokens[0, ..., sight.button] > 0]
    views = views.masked_fill(button > 0, 9).sort(-1).values
    assert (views[:, :3] == torch.arange(3)).all()


def test_recollection_keeps_what_the_tool_has_touched(learners: SimpleNamespace) -> None:
    rows, sight = episodes(learners, "BunchOfColors3-VLA-v0", steps=100)
    policy = fitted(learners, rows, sight)
    tokens = sight.split(rows)[1]
    touched = learners.policy.Recollection.labels(policy, rows)[2][-1, ..., -1] > 0
    cue = policy.code(sight.pairs(tokens))[0].amax(-2)  # three cubes to touch, and the button
    touched_looks = (policy.code(sight.pairs(tokens))[-1] * touched[..., None]).amax(-2)
    assert (touched.sum(-1) == 3).all()
    assert (touched_looks <= cue).all()


# --- the policy ---


@pytest.mark.parametrize("memory", [True, False])
def test_step_by_step_is_as_all_at_once(learners: SimpleNamespace, memory: bool) -> None:
    rows, sight = episodes(learners, LAMP, 4)
    policy = fitted(learners, rows, sight, memory)
    with torch.no_grad():
        whole = policy(rows)[0]
        state = None
        for t, row in enumerate(rows):
            choice, _, state, _ = policy(row[None], state)
            np.testing.assert_allclose(choice.mean[0], whole.mean[t], atol=1e-5)
            np.testing.assert_allclose(choice.weights[0], whole.weights[t], atol=1e-4)


def test_only_a_memory_tells_equal_sights_apart(learners: SimpleNamespace) -> None:
    rows, sight = episodes(learners, COLOR3)
    late = rows.clone()
    late[10:] = rows[10:, :1]  # the same sight for all, after different cues
    for memory in (True, False):
        with torch.no_grad():
            mean = fitted(learners, rows, sight, memory)(late)[0].best()[10:]
        assert (mean == mean[:, :1]).all().item() != memory


def test_a_wiped_memory_is_that_of_a_new_episode(learners: SimpleNamespace) -> None:
    rows, sight = episodes(learners, COLOR3, 4)
    policy = fitted(learners, rows, sight)
    which = torch.tensor([True, False, True, False])
    with torch.no_grad():
        state = policy(rows[:12])[2]
        wiped = policy(rows[12:13], policy.wipe(state, which))[0].mean[0]
        fresh = policy(rows[12:13])[0].mean[0]
        kept = policy(rows[12:13], state)[0].mean[0]
    assert torch.equal(wiped[which], fresh[which])
    assert torch.equal(wiped[~which], kept[~which])
    assert not torch.equal(fresh, kept)


def test_actions_are_those_for_the_object_of_most_weight(learners: SimpleNamespace) -> None:
    weights = torch.log(torch.tensor([[[0.2, 0.5, 0.3]]]))
    mean = torch.arange(3.0)[None, None, :, None].expand(1, 1, 3, 7) - 0.5
    choice = learners.policy.Choice(weights, mean, torch.zeros_like(mean))
    assert (choice.best() == 0.5).all()
    np.testing.assert_allclose(choice.mixed()[0], 0.6, atol=1e-6)


def test_a_new_hand_goes_to_the_object_that_is_picked(learners: SimpleNamespace) -> None:
    rows, sight = episodes(learners, COLOR3)
    with torch.no_grad():
        choice = fitted(learners, rows, sight)(rows)[0]
    seen = sight.split(rows)[1][..., 0] > 0
    toward, mean = sight.to_top(rows)[seen], choice.mean[..., :3][seen]
    far = toward.abs() > 0.3
    assert (mean.sign() == toward.sign())[far].all()
    assert (mean.abs() > 0.9)[far].all()


def test_a_new_policy_without_memory_goes_to_what_is_near(learners: SimpleNamespace) -> None:
    """So it guesses an object, rather than to stay between them."""
    rows, sight = episodes(learners, COLOR3)
    with torch.no_grad():
        weights = fitted(learners, rows, sight, memory=False)(rows)[0].weights
    agent, tokens = sight.split(rows)
    away = (tokens[..., sight.place] - agent[..., None, sight.tcp])[..., :2].norm(dim=-1)
    ordered, which = away.masked_fill(tokens[..., 0] == 0, 9).sort(-1)
    clear = (ordered[..., 1] - ordered[..., 0] > 0.1) & (tokens[..., 0].sum(-1) == 3)  # by 0.05 m
    assert clear.sum() > 10
    assert (weights.argmax(-1) == which[..., 0])[clear].all()


# --- distillation ---


def test_the_oracle_leads_the_first_episodes_and_half_of_the_others(
    learners: SimpleNamespace,
) -> None:
    scenes = learners.play.Objects(COLOR3, 64, seed=3)
    policy = fitted(learners, *episodes(learners, COLOR3), memory=False)
    scenes.reset(seed=3)
    learners.distil.collect(policy, scenes, first=True)
    assert scenes.infos["success_once"].all()
    torch.manual_seed(1)
    learners.distil.collect(policy, scenes, first=False)
    assert 0.05 < scenes.infos["success_once"].mean() < 0.6


def test_attention_learns_which_object_the_oracle_means(learners: SimpleNamespace) -> None:
    weights = torch.zeros(2, requires_grad=True)
    mean = torch.stack([torch.zeros(7), torch.ones(7)])[None, None].requires_grad_()
    choice = learners.policy.Choice(weights.log_softmax(-1)[None, None], mean, mean)
    learners.distil.imitation(choice, torch.full((1, 1, 7), 0.9)).sum().backward()
    assert weights.grad[1] < -0.01 < 0.01 < weights.grad[0]
    assert mean.grad[0, 0, 1].abs().min() > 1e-2 > 1e-4 > mean.grad[0, 0, 0].abs().max()


# --- reinforcement learning ---


def test_advantages_equal_their_definition(learners: SimpleNamespace) -> None:
    generator = torch.Generator().manual_seed(1)
    rewards = torch.rand(9, 3, generator=generator)
    values = torch.rand(9, 3, generator=generator)
    args = SimpleNamespace(gamma=0.8, gae=0.7)
    after = torch.cat([values[1:], torch.zeros(1, 3)])
    errors = rewards + 0.8 * after - values
    expected = [sum((0.56**k) * errors[t + k] for k in range(9 - t)) for t in range(9)]
    np.testing.assert_allclose(
        learners.ppo.advantages(rewards, values, args), torch.stack(expected), rtol=1e-5
    )


# --- pictures ---


def test_an_eye_knows_where_the_camera_is(learners: SimpleNamespace) -> None:
    scenes = learners.pictures.Pictures(COLOR3, 16, seed=5)
    scenes.reset(seed=5)
    for _ in range(15):
        scenes.step(scenes.oracle())
    picture, tokens = scenes.last
    place = tokens[..., scenes.sight.place]
    pixels = learners.eye.spot(place)
    at = learners.eye.place_at(pixels, place[..., 2])
    np.testing.assert_allclose(at, place[..., :2], atol=1e-5)
    column, line = pixels.round().long().unbind(-1)
    colors = picture[torch.arange(16)[:, None], line, column].float()  # of cubes: red, lime, blue
    meant = scenes.eye.looks // (scenes.objects.shapes + 1)
    assert meant.tolist() == [0, 1, 2]
    assert (colors.argmax(-1) == meant).float().mean() > 0.8  # the arm hides some


def test_an_eye_learns_where_things_are(learners: SimpleNamespace) -> None:
    torch.manual_seed(0)
    scenes = learners.pictures.Pictures(COLOR3, 16, seed=5)
    assert len(scenes.eye.looks) == 3
    scenes.reset(seed=5)
    for _ in range(scenes.horizon):
        scenes.keep()
        scenes.step(scenes.oracle())
    scenes.learn(150)
    rows = scenes.reset(seed=99)
    for _ in range(8):
        rows, _ = scenes.step(scenes.oracle())
    seen, true = (scenes.sight.split(r)[1] for r in (rows, scenes.truth))
    assert (seen[..., 0] == true[..., 0]).float().mean() > 0.9
    away = (seen - true)[..., scenes.sight.place].norm(dim=-1)[true[..., 0] > 0]
    assert away.median() * 0.5 < 0.02  # m; the cubes are spread over 0.4 m


# --- learners ---


def run(script: str, *arguments: str) -> list[str]:
    command = [sys.executable, str(EXAMPLES / script), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


DISTIL = ["distil.py", "--iterations", "2", "--updates", "4", "--evaluate-every", "1"]
PPO = ["--steps", "1600", "--evaluate-every", "1"]


@pytest.mark.parametrize(
    "command",
    [
        [*DISTIL, "--envs", "32"],
        [*DISTIL, "--envs", "16", "--no-memory"],
        [*DISTIL, "--envs", "16", "--obs", "rgb", "--eye-updates", "3"],
        ["ppo_recurrent.py", *PPO, "--envs", "32"],
        ["memoryless.py", *PPO, "--envs", "32"],
    ],
    ids=["distil", "distil_no_memory", "distil_rgb", "ppo_recurrent", "memoryless"],
)
def test_a_learner_runs_and_resumes(
    learners: SimpleNamespace, tmp_path: Path, command: list[str]
) -> None:
    lines = run(*command, "--out", str(tmp_path))
    result = json.loads(lines[-1])
    assert result == json.loads((tmp_path / "result.json").read_text())
    assert 0 <= result["success_once"] <= 1
    remembers = "--no-memory" not in command and command[0] != "memoryless.py"
    assert ("wiped" in result) == remembers
    with (tmp_path / "log.csv").open(newline="") as file:
        assert len(list(csv.DictReader(file))) == 2
    assert (tmp_path / "curve.png").stat().st_size > 0
    logged = list(tmp_path.glob("events.out.tfevents.*"))
    assert logged or not importlib.util.find_spec("tensorboard")
    policy, eye, task = learners.play.load_policy(tmp_path / "agent.pt")
    assert (policy.memory, eye is not None, task) == (remembers, "rgb" in command, COLOR3)
    run(*command, "--out", str(tmp_path), "--resume")


def test_distilling_learns(tmp_path: Path) -> None:
    """A few seconds suffice for more than those get who do not remember (0.33)."""
    arguments = ["--iterations", "4", "--evaluate-every", "4", "--out", str(tmp_path)]
    result = json.loads(run("distil.py", *arguments)[-1])
    assert result["success_once"] > 0.8
    assert result["wiped"]["success_once"] < 0.6


def test_reinforcement_learns_with_memory_alone(tmp_path: Path) -> None:
    """Half of the steps that ppo_recurrent.py takes by itself; without memory it is luck."""
    arguments = ["--steps", "100000", "--evaluate-every", "1000", "--out", str(tmp_path)]
    result = json.loads(run("ppo_recurrent.py", *arguments)[-1])
    assert result["success_once"] > 0.8
    assert result["wiped"]["success_once"] < 0.6
    control = json.loads(run("memoryless.py", *arguments)[-1])
    assert control["first_answer_correct"] < 0.5


def test_processes_learn_together() -> None:
    command = [sys.executable, "-m", "torch.distributed.run", "--nproc-per-node", "2"]
    script = [str(EXAMPLES / "ppo_recurrent.py"), *PPO, "--envs", "32"]
    done = subprocess.run([*command, *script], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    results = [line for line in done.stdout.splitlines() if '"learner"' in line]
    assert len(results) == 1  # the first process tells
