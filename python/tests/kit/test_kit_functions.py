"""Functions with the same bits everywhere, and the servos, on the engine's own code."""

from __future__ import annotations

import math

import numpy as np
import pytest
from task_columns import ColumnsByHand

import engram
from engram import kit

X = np.linspace(-0.9, 0.9, 13)


@pytest.mark.parametrize(
    ("function", "expected", "x"),
    [
        (kit.sin, math.sin, X), (kit.cos, math.cos, X), (kit.tan, math.tan, X),
        (kit.asin, math.asin, X), (kit.exp, math.exp, X), (kit.log, math.log, X + 1),
        (kit.tanh, math.tanh, X),
    ],
)  # fmt: skip
def test_functions_of_one_number(function, expected, x):
    np.testing.assert_allclose(function(x), [expected(one) for one in x], rtol=1e-14, atol=1e-15)
    assert function(np.float32(0.5)).shape == ()
    assert function(x.reshape(1, 13)[:, ::2]).shape == (1, 7)
    np.testing.assert_array_equal(function(x[::2]), function(x)[::2])


def test_functions_of_two_numbers():
    np.testing.assert_allclose(kit.atan2(X, 0.5), np.arctan2(X, 0.5), rtol=1e-14)
    np.testing.assert_allclose(kit.hypot(X[:, None], X), np.hypot(X[:, None], X), rtol=1e-14)
    with pytest.raises(engram.InvalidArgumentError, match="do not go together"):
        kit.atan2(X, X[:3])


def test_lengths_do_not_depend_on_the_number_of_rows():
    vectors = np.random.default_rng(0).normal(size=(100, 13))
    lengths = kit.length(vectors)
    np.testing.assert_allclose(lengths, np.linalg.norm(vectors, axis=1), rtol=1e-14)
    for i in range(0, 100, 9):
        assert kit.length(vectors[i : i + 1])[0] == lengths[i]
    assert kit.length(vectors.reshape(10, 10, 13)).tolist() == lengths.reshape(10, 10).tolist()
    assert kit.distance(vectors[:, :3], np.zeros(3)).shape == (100,)
    assert kit.length(np.array([3.0, 4.0])) == 5


class Idle(engram.Task):
    def evaluate(self):
        pass

    def reward(self):
        return np.zeros(self.n)


@pytest.fixture
def task():
    columns = ColumnsByHand(Idle)
    columns.all["tcp_pos"][:] = (0, 0, 0.2)
    columns.all["tcp_quat"][:] = kit.TOOL_DOWN
    columns.all["episode"][:, 0] = [0, 1, 2, 2]
    columns.call("reset")
    return columns.task


def test_servos_move_towards_goals(task):
    goals = np.array([[0.01, 0, 0.2], [0, -1, 0.2], [0, 0, 0.1], [0, 0, 0.2]])
    task.servo(goals, gripper=kit.GRIPPER_OPEN)
    assert task.actions[0].tolist() == pytest.approx([0.16, 0, 0, 0, 0, 0, 1], abs=1e-6)
    assert task.actions[1, 1] == -1
    assert task.actions[2, 2] == -1
    assert task.actions[3, :6].tolist() == pytest.approx([0] * 6, abs=1e-6)
    task.rest(where=np.array([True, False, False, False]), gripper=0.5)
    assert task.actions[0].tolist() == [0, 0, 0, 0, 0, 0, 0.5]
    assert task.actions[1, 1] == -1
    assert task.from_above((0, 0, 0.02), 0.05)[0].tolist() == pytest.approx([0, 0, 0.02])
    assert task.from_above((0.2, 0, 0.02), 0.05)[0].tolist() == pytest.approx([0.2, 0, 0.07])
    assert task.lean((0.1, 0, 0))[0].tolist() == pytest.approx(kit.TOOL_DOWN)
    assert task.lean((0.3, 0, 0))[0].tolist() != pytest.approx(kit.TOOL_DOWN)
    with pytest.raises(engram.InvalidArgumentError, match=r"goal: shape \(2,\) given; \(3,\) or"):
        task.servo((0, 0))
    with pytest.raises(engram.InvalidArgumentError, match="where: int64"):
        task.rest(where=np.ones(4, int))


def test_tours_begin_at_the_nearest_stop(task):
    stops = np.broadcast_to([[0, -0.2, 0.03], [0, 0.05, 0.03]], (4, 2, 3))
    task.tour(stops)
    assert (task.actions[:, 1] > 0).all()
    with pytest.raises(engram.InvalidArgumentError, match=r"stops: shape \(2, 3\) given"):
        task.tour(stops[0])


def test_guesses_stay_the_same_in_an_episode(task):
    guesses = task.guess(1000)
    assert guesses.tolist() == task.guess(1000).tolist()
    assert guesses[2] == guesses[3]
    assert len(set(guesses[:3].tolist())) == 3
    assert task.guess(5, width=7).shape == (4, 7)
    orders = task.guess_order(6)
    assert np.sort(orders, axis=1).tolist() == [list(range(6))] * 4
    assert (task.uniforms(50) >= 0).all()
    assert (task.uniforms(50) < 1).all()
