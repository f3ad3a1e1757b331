"""Calls of a task's methods: rows, views, results and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from task_columns import ColumnsByHand

import engram
from engram import kit


class Counter(engram.Task):
    """Counts steps, in every environment from its own draw on."""

    frozen_cue = True

    def build(self):
        self.offsets = np.arange(3)
        self.names = ["a", "b"]
        self.cube = self.add_prop(kit.Cube("cube"))
        self.draw_integer("begin", 0, 9, text="the first number")
        self.draw_integer("cue_steps", 1, 4, text="length of the cue")
        self.remember("count")
        self.add_phases(("cue", "cue_steps"), "act")
        self.add_state("count", text="the number")
        self.add_state("pair", 2, text="twice")

    def reset(self):
        self.count[:] = self.begin

    def advance(self):
        self.count += 1
        self.success[:] = self.count > 5

    def evaluate(self):
        pass

    def reward(self):
        return self.count * 0.5

    def observe(self):
        return {"count": self.count, "pair": np.stack([self.count, self.count], axis=1)}

    def oracle(self):
        return np.full((self.n, 7), 0.25)


def test_methods_write_into_the_columns():
    columns = ColumnsByHand(Counter)
    columns.reset(begin=[0, 2, 4, 8], cue_steps=[1, 2, 3, 4])
    assert columns.all["memory:count"][:, 0].tolist() == [1, 3, 5, 9]
    assert columns.all["state"].tolist() == [[c, c, c] for c in (1, 3, 5, 9)]
    assert columns.all["success"][:, 0].tolist() == [0, 0, 0, 1]
    assert columns.all["cue_end"][:, 0].tolist() == [1, 2, 3, 4]
    assert columns.all["freeze_steps"][:, 0].tolist() == [1, 2, 3, 4]
    assert columns.all["prop_quat"].tolist() == [[1, 0, 0, 0]] * 4
    columns.step()
    assert columns.all["reward"][:, 0].tolist() == [1, 2, 3, 5]
    columns.call("oracle")
    assert (columns.all["actions"] == 0.25).all()


def test_parts_of_a_batch_are_like_the_whole():
    columns = ColumnsByHand(Counter)
    columns.reset(begin=0, cue_steps=2)
    columns.step()
    columns.reset([3, 1], begin=7)
    assert columns.all["memory:count"][:, 0].tolist() == [2, 8, 2, 8]
    columns.step()  # of all again
    assert columns.all["memory:count"][:, 0].tolist() == [3, 9, 3, 9]
    columns.reset([0], begin=5)
    assert columns.task.n == 1
    assert columns.all["memory:count"][:, 0].tolist() == [6, 9, 3, 9]


def test_phases_follow_the_draws():
    columns = ColumnsByHand(Counter)
    columns.reset(cue_steps=[1, 2, 3, 4])
    columns.all["elapsed"][:] = 2
    task = columns.task
    assert task.begins("act").tolist() == [False, True, False, False]
    assert task.in_phase("cue").tolist() == [False, False, True, True]
    assert task.in_phase("act").tolist() == [True, True, False, False]
    assert task.start_of("act").tolist() == [1, 2, 3, 4]
    assert task.start_of("cue").tolist() == [0] * 4
    with pytest.raises(engram.InvalidArgumentError, match="'later' given; allowed: cue, act"):
        task.begins("later")


def refusal(method="advance", **methods):
    """What a step says of a Counter with other methods."""
    cls = type("Refused", (Counter,), methods)
    columns = ColumnsByHand(cls)

    def run():
        columns.reset()
        columns.step()

    with pytest.raises(Exception) as refused:  # noqa: PT011 (tests compare type and text)
        run()
    return refused.value


@pytest.mark.parametrize(
    ("methods", "message"),
    [
        ({"reset": lambda t: setattr(t, "count", 1)}, "self.count[:] = ... writes into it"),
        ({"advance": lambda t: setattr(t, "success", 1)}, "self.success[:] = ..."),
        ({"advance": lambda t: setattr(t, "total", 1)}, 'self.remember("total", ...)'),
        ({"evaluate": lambda t: t.count > 3}, "evaluate: returned a value"),
        ({"reward": lambda t: None}, "reward: None returned; an array of numbers"),
        ({"reward": lambda t: np.zeros(3)}, "reward: an array of shape (3,) returned; (4,) needed"),
        ({"observe": lambda t: {"count": t.count}}, "observe: state field 'pair' missing"),
        ({"observe": lambda t: {"pair": 0, "count": t.count}}, "pair: an array of shape ()"),
        (
            {"observe": lambda t: {**Counter.observe(t), "more": 1}},
            "observe: more given; build() declares no such",
        ),
    ],
)
def test_mistakes_are_refused_with_a_sentence(methods, message):
    error = refusal(**methods)
    assert isinstance(error, engram.Error)
    assert message in str(error)


def test_what_was_built_cannot_change():
    assert "read-only" in str(refusal(advance=lambda t: t.offsets.fill(1)))
    assert "append" in str(refusal(advance=lambda t: t.names.append("c")))
    assert "read-only" in str(refusal(advance=lambda t: t.elapsed.fill(1)))
    assert "read-only" in str(refusal(advance=lambda t: t.begin.fill(1)))


def test_exceptions_of_methods_come_out_as_they_are():
    def advance(self):
        raise ZeroDivisionError("of the user")

    assert isinstance(refusal(advance=advance), ZeroDivisionError)


def test_arrays_exist_only_in_methods():
    columns = ColumnsByHand(Counter)
    with pytest.raises(engram.BadStateError, match=r"self\.count: arrays exist only"):
        _ = columns.task.count
    with pytest.raises(AttributeError, match="'Counter' object has no attribute 'other'"):
        _ = columns.task.other


def test_optional_methods_are_listed():
    class Full(Counter):
        def before_physics(self):
            pass

        def sweep(self):
            self.rest()

    columns = ColumnsByHand(Full)
    assert columns.description["methods"] == ["before_physics", "oracle", "sweep"]
    columns.reset()
    columns.call("sweep")
    assert columns.all["actions"][0].tolist() == [0, 0, 0, 0, 0, 0, np.float32(kit.GRIPPER_CLOSED)]
    columns.call("oracle")
    with pytest.raises(engram.BadStateError, match=r"Full has no method blind"):
        columns.call("blind")


@pytest.mark.parametrize(
    ("attributes", "message"),
    [
        ({"elapsed": 3}, "class Bad: elapsed is a column of the engine"),
        ({"place": lambda t: None}, "class Bad: place is a method of engram.Task; another name"),
        ({"describe": lambda t: ""}, "class Bad: describe is a method"),
        ({"__init__": lambda t: None}, r"class Bad: __init__ given; build\(\) declares"),
    ],
)
def test_names_of_the_base_class_are_refused(attributes, message):
    with pytest.raises(engram.InvalidArgumentError, match=message):
        type("Bad", (Counter,), attributes)


def test_touches_are_answers():
    class Touch(engram.Task):
        answer = "a point"

        def build(self):
            self.points = np.array([[0.0, 0, 0], [0.1, 0, 0]])
            self.draw_integer("right", 0, 1, text="the point to touch")

        def evaluate(self):
            points = np.broadcast_to(self.points, (self.n, 2, 3))
            self.answer_by_touch(points, self.right, 0.05, where=self.elapsed > 0)

        def reward(self):
            return self.success * 1.0

    columns = ColumnsByHand(Touch)
    columns.all["tcp_pos"][:] = [[0, 0, 0], [0, 0, 0], [0.1, 0, 0], [0.1, 0.2, 0]]
    columns.reset(right=[0, 1, 1, 0])
    assert not columns.all["answered"].any()
    columns.all["qvel"][2, 0] = 1
    columns.step()
    assert columns.all["success"][:, 0].tolist() == [1, 0, 0, 0]
    assert columns.all["answered"][:, 0].tolist() == [1, 1, 0, 0]
    assert columns.all["first_answer_correct"][:, 0].tolist() == [1, 0, 0, 0]
    columns.all["qvel"][:] = 0
    columns.step()
    assert columns.all["first_answer"][:, 0].tolist() == [0, 0, 1, 0]
    assert columns.all["reward"][:, 0].tolist() == [1, 0, 1, 0]
