"""engram_learners/keyframes.py and the policy's servo: against the engine's own numbers."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from programs import learners, torch

pytest.importorskip("matplotlib")

ROTATE = "RotateStrictPosNeg-VLA-v0"


def played(
    task: str, steps: int, names: tuple[str, ...] = (), envs: int = 16
) -> tuple[Any, Any, Any, dict[str, Any]]:
    """Oracle's episodes: layout, rows (T, N, D), actions (T, N, A), infos (T, N) by name."""
    env = learners.training.ObjectsEnv(task, envs, 3)
    row, rows, actions = env.reset(seed=3), [], []
    infos: dict[str, Any] = {name: [] for name in names}
    for _ in range(steps):
        action = env.oracle()
        rows.append(row)
        actions.append(action)
        for name, values in infos.items():
            values.append(torch.from_numpy(np.array(env.infos[name])))
        row, _ = env.step(action)
    stacked = {name: torch.stack(values) for name, values in infos.items()}
    return env.layout, torch.stack(rows), torch.stack(actions), stacked


def features(layout: Any, rows: Any) -> tuple[Any, Any, Any]:
    tokens = layout.split(rows)[1]
    new = learners.keyframes.arrivals(layout.bodies(tokens, layout.pairs(tokens)))
    return learners.keyframes.keyframes(layout, rows, new, None)


def test_the_turn_since_the_first_step_is_the_engine_s() -> None:
    layout, rows, _, infos = played(ROTATE, 70, ("relative_angle",))
    since = features(layout, rows)[0]
    angle = since[:, :, 0, 5]
    turned = infos["relative_angle"].reshape(angle.shape)
    assert turned[-1].abs().max() > 0.5
    np.testing.assert_allclose(angle[1:], turned[1:], atol=1e-4)


def test_a_clock_counts_from_the_signal() -> None:
    names = ("signal_on",)
    layout, rows, _, infos = played("TimedTransferEasy-VLA-v0", 40, names)
    _, clocks, kept = features(layout, rows)
    since_view, since_change = clocks[..., 0], clocks[..., learners.keyframes.N_CLOCK // 2]
    counted = infos["signal_on"].float().sum(0) - 1  # steps since the lamp went on
    np.testing.assert_allclose((3 * since_view[-1]).exp() - 1, 39, rtol=1e-4)
    np.testing.assert_allclose((3 * since_change[-1]).exp() - 1, counted, rtol=1e-4)
    assert counted.unique().numel() > 1
    assert (kept[:, 0, -1] == counted).all()


def test_the_tool_s_way_since_a_press_is_that_of_the_lift() -> None:
    """A press counts when the tool has risen by 0.085 m since it went on."""
    names = ("pending_press", "press_count")
    layout, rows, _, infos = played("BlinkCountButtonPressEasy-VLA-v0", 70, names)
    tokens = layout.split(rows)[1]
    red = (tokens[..., layout.part["color"]][..., 0] > 0) & (tokens[..., layout.button] > 0)
    rise = 0.1 * features(layout, rows)[0][..., 8][red].reshape(len(rows), -1)
    pending = infos["pending_press"].reshape(rise.shape) > 0
    assert pending.any()
    assert (rise[pending] < 0.085).all()
    counts = infos["press_count"].reshape(rise.shape)
    confirmed = counts[1:] > counts[:-1]
    assert confirmed.any()
    assert (rise[1:][confirmed] >= 0.085 - 1e-6).all()


def test_keyframes_go_on_from_what_is_kept() -> None:
    layout, rows, _, _ = played("BlinkCountButtonPressEasy-VLA-v0", 60)
    tokens = layout.split(rows)[1]
    bodies = layout.bodies(tokens, layout.pairs(tokens))
    new = learners.keyframes.arrivals(bodies)
    whole = learners.keyframes.keyframes(layout, rows, new, None)
    kept, parts = None, []
    for part, begins in zip(rows.split(7), new.split(7)):
        *part_of, kept = learners.keyframes.keyframes(layout, part, begins, kept)
        parts.append(part_of)
    for i in range(2):
        np.testing.assert_allclose(torch.cat([p[i] for p in parts]), whole[i], atol=1e-5)
    np.testing.assert_allclose(kept, whole[2], atol=1e-5)


def test_the_servo_turns_the_tool_as_the_oracle() -> None:
    """Upright and across the peg, ahead of it by what is left of the turn (at most 0.3)."""
    layout, rows, actions, _ = played(ROTATE, 10, envs=128)
    agent, tokens = layout.split(rows)
    turn = learners.rotations.relative(layout.tool_yaw(agent)[..., None, :], layout.yaw(tokens))
    ahead = (math.pi * agent[..., 25]).clamp(-0.3, 0.3)  # task_cue
    error = learners.rotations.alignments(turn)[0][..., 0] + ahead
    upright = learners.rotations.tilt(agent[..., layout.tool])
    rotation = -16 * torch.cat([upright, error[..., None]], -1)
    free = (rotation.norm(dim=-1) < 1) & (actions[..., 3:6].norm(dim=-1) < 0.99)
    free &= agent[..., layout.tcp][..., 2] > 0.12  # farther down it keeps its yaw
    assert free.sum() > 10
    np.testing.assert_allclose(rotation[free], actions[..., 3:6][free], atol=0.02)


def test_the_oracle_s_limited_actions_may_be_exceeded() -> None:
    actions = torch.tensor([[[1.0, -1.0, 0.5, 0.6, 0.0, -0.8, 1.0]]])
    beyond = torch.tensor([2.0, -3.0, 0.5, 0.9, 0.0, -1.2, 1.0])

    def distance(mean: Any) -> float:
        choice = learners.policy.Choice(torch.zeros(1, 1, 1), mean[None, None, None], None)
        return float(learners.distil.imitation(choice, actions))

    assert distance(beyond) < 1e-6
    assert distance(beyond * torch.tensor([1, 1, 2, 1, 1, 1, 1])) > 0.1  # 0.5 is not limited
    assert distance(beyond * torch.tensor([1, 1, 1, 1, 1, -1, 1])) > 0.5  # the wrong way


def test_with_a_smaller_huber_small_errors_weigh_more() -> None:
    actions, mean = torch.zeros(1, 1, 7), torch.zeros(1, 1, 1, 7)
    choice = learners.policy.Choice(torch.zeros(1, 1, 1), mean, None)
    mean[..., 0] = 0.05  # squares in both
    fine, coarse = (float(learners.distil.imitation(choice, actions, huber=h)) for h in (0.1, 0.3))
    assert fine == pytest.approx(3 * coarse)
    mean[..., 0] = 0.9  # linear in both
    fine, coarse = (float(learners.distil.imitation(choice, actions, huber=h)) for h in (0.1, 0.3))
    assert fine == pytest.approx(0.85)
    assert coarse == pytest.approx(0.75)


def test_a_false_motion_weighs_as_much_as_a_true_one() -> None:
    """Rests that the student keeps weigh a tenth."""
    actions = torch.zeros(3, 1, 7)
    actions[0, 0, 0] = 0.5
    mean = actions[..., None, :].clone()
    mean[1, ..., 0] = 0.8  # the oracle rests here, and in the last step
    choice = learners.policy.Choice(torch.zeros(3, 1, 1), mean, None)

    class Student(SimpleNamespace):
        memory = False

        def __call__(self, _rows: Any, _state: Any) -> Any:
            return choice, None, None, None

    action, _ = learners.distil.losses_of(Student(), None, actions)
    error = learners.distil.imitation(choice, actions)
    np.testing.assert_allclose(action, error[1, 0] / 2.1, rtol=1e-5)


def test_steps_after_an_early_end_have_no_label() -> None:
    """BlinkCount ends when a wrong count is submitted."""
    env = learners.training.ObjectsEnv("BlinkCountButtonPressEasy-VLA-v0", 8, 3)
    env.reset(seed=3)
    torch.manual_seed(0)
    policy = learners.policy.Policy(env.layout)
    env.oracle = lambda: torch.from_numpy(env.batch.act("blind")).clamp(-1, 1)
    actions = learners.distil.collect(policy, env, first=True)[1]
    labelled = actions.isfinite().all(-1)
    elapsed = torch.from_numpy(np.array(env.infos["elapsed_steps"]))
    assert elapsed.min() < env.horizon == elapsed.max()
    assert (labelled.sum(0) == elapsed).all()


def test_what_remains_of_a_commanded_turn_is_the_engine_s_error() -> None:
    layout, rows, _, infos = played(ROTATE, 70, ("y_angle_error",))
    remains = features(layout, rows)[0][:, :, 0, -3]
    error = infos["y_angle_error"].reshape(remains.shape)
    assert error.abs().max() > 0.5
    np.testing.assert_allclose(remains[1:], error[1:], atol=2e-3)
