"""Declarations in build(): the description that the engine gets, and refusals."""

from __future__ import annotations

import re

import numpy as np
import pytest
from task_columns import ColumnsByHand

import engram
from engram import kit


class Everything(engram.Task):
    WAIT = kit.Steps(2, 5, text="how long to wait")
    SPEED = kit.RealRange(0.1, 0.2, low=0, high=1, unit="m/s", text="how fast")

    answer = "the lamp that is touched first"
    hidden = "order"
    oracle_dim = 2
    frozen_cue = True

    def build(self):
        self.candidates = 6
        self.base = self.add_prop(kit.ButtonBase("base"))
        self.balls = self.add_props(kit.Sphere(f"ball_{i}", radius=0.03) for i in range(3))
        self.draw_integer("spot", 0, 2, text="where")
        self.draw_real("turn", -1, 1, width=2, unit="rad", text="angles")
        self.draw_order("order", 3, text="order of the lamps")
        self.draw_choice("chosen", 2, 5, text="two of five")
        self.draw_places("places", 3, (0, -1), (1, 1), least_distance=0.1, text="places")
        self.draw_range("wait", "WAIT")
        self.draw_range("speed", "SPEED", width=2)
        self.remember("seen", bool, width=3)
        self.remember("path", float, width=(4, 2), unit="m", text="where it was")
        self.remember("last", low=-1, high=2)
        self.add_info("away", unit="m")
        self.add_info("touched", bool, width=3, privileged=True)
        self.add_state("spot_is", text="where")
        self.add_state("ball_pos", 9, unit="m", text="positions")
        self.add_phases(("cue", "wait"), ("empty", 4), "act")


def test_the_description_has_all_that_was_declared():
    described = ColumnsByHand(Everything).description
    assert described["candidates"] == 6
    assert described["hidden"] == "order"
    assert [prop["kind"] for prop in described["props"]] == ["button_base"] + ["sphere"] * 3
    draws = {draw["name"]: draw for draw in described["draws"]}
    assert draws["spot"] == {
        "name": "spot", "kind": "integer", "text": "where", "unit": "", "low": 0, "high": 2,
        "width": 1,
    }  # fmt: skip
    assert draws["order"]["count"] == 3
    assert draws["chosen"]["of"] == 5
    assert draws["places"]["low"] == [0, -1]
    assert draws["places"]["least_distance"] == 0.1
    assert (draws["wait"]["constant"], draws["wait"]["low"], draws["wait"]["high"]) == (
        "WAIT",
        2,
        5,
    )
    assert (draws["speed"]["kind"], draws["speed"]["unit"]) == ("real", "m/s")
    assert [(one["dtype"], one["width"]) for one in described["memory"]] == [
        ("bool", 3), ("float64", 8), ("int32", 1),
    ]  # fmt: skip
    assert (described["memory"][2]["low"], described["memory"][2]["high"]) == (-1, 2)
    assert "low" not in described["memory"][0]
    assert [one["privileged"] for one in described["infos"]] == [False, True]
    assert described["infos"][0]["dtype"] == "float32"
    assert described["state_fields"][1]["width"] == 9
    assert described["phases"] == [
        ["cue", "elapsed < wait"],
        ["empty", "wait <= elapsed < wait + 4"],
        ["act", "elapsed >= wait + 4"],
    ]
    assert described["methods"] == []


def test_columns_have_natural_shapes():
    columns = ColumnsByHand(Everything, num_envs=5)
    columns.call("reset")
    task = columns.task
    shapes = {
        "spot": (5,), "turn": (5, 2), "order": (5, 3), "places": (5, 3, 2), "speed": (5, 2),
        "seen": (5, 3), "path": (5, 4, 2), "last": (5,), "away": (5,), "touched": (5, 3),
        "elapsed": (5,), "prop_pos": (5, 4, 3), "finger_force": (5, 4, 2, 3), "qpos": (5, 9),
        "oracle_info": (5, 2), "answered": (5,), "success": (5,), "prop_status": (5, 4),
    }  # fmt: skip
    assert {name: getattr(task, name).shape for name in shapes} == shapes
    assert task.seen.dtype == task.success.dtype == np.bool_
    assert list(task.balls) == [1, 2, 3]
    assert task.balls[1] == 2
    assert task.balls[np.array([2, 0])].tolist() == [3, 1]


def build_of(build, **facts):
    """The refusal of a task that is built so."""

    class Refused(engram.Task):
        WAIT = kit.Steps(1, 5, text="")

    Refused.build = build
    for name, value in facts.items():
        setattr(Refused, name, value)
    with pytest.raises(engram.Error) as refused:
        ColumnsByHand(Refused)
    return str(refused.value)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda t: t.remember("reset"), "'reset' given, which is another attribute of Refused"),
        (lambda t: t.remember("elapsed"), "'elapsed' given, which is a column of the engine"),
        (lambda t: t.remember("WAIT"), "another attribute"),
        (lambda t: [t.remember("one"), t.add_info("one")][0], "declared already"),
        (lambda t: t.remember("a b"), "a Python name"),
        (lambda t: t.remember("_x"), "without _ first"),
        (lambda t: t.remember("x", "text"), "dtype of memory 'x': 'text' given; allowed: bool"),
        (lambda t: t.remember("x", width=0), "width: 0 given"),
        (lambda t: t.remember("x", low=1), "low=1, high=None given; both"),
        (lambda t: t.remember("x", float, low=1, high=2), "of whole numbers"),
        (lambda t: t.add_prop("cube"), "prop: 'cube' given; one of engram.kit"),
        (lambda t: t.add_props([]), "props: none given"),
        (lambda t: t.add_props([kit.Cube("a"), kit.Mug("a")]) and None, "each needs its own"),
        (lambda t: t.draw_integer("x", 3, 2, text=""), "low: 3 given; at most high, 2"),
        (lambda t: t.draw_range("x", "WAITS"), "constant: 'WAITS' given; the name of"),
        (lambda t: t.draw_choice("x", 6, 5, text=""), "count: 6 given; allowed: 1 to 5"),
        (lambda t: t.add_phases("act"), "two or more"),
        (lambda t: t.add_phases(("cue", "x"), "act"), "'x' given; a draw of whole numbers"),
        (lambda t: t.add_phases("cue", "act"), r"'cue' given; \(name, length\)"),
        (lambda t: t.add_phases(("cue", 3), ("cue", 4), "act"), "'cue' given twice"),
        (lambda t: t.add_phases(("cue", 60), "act"), "no time to act: 60 . 1 to act = 61"),
        (lambda t: 3, "build: returned a value"),
        (lambda t: setattr(t, "success", 3), "success is a column; another name"),
        (lambda t: setattr(t, "WAIT", 3), "WAIT is a constant of Refused"),
        (lambda t: setattr(t, "reward", 3), "reward is a method"),
    ],
)
def test_bad_declarations_are_refused(build, message):
    assert re.search(message, build_of(build))


@pytest.mark.parametrize(
    ("facts", "message"),
    [
        ({"candidates": 0}, "candidates: 0 given"),
        ({"termination": "later"}, "termination: 'later' given; allowed: never, success"),
        ({"success_reward": 0}, "success_reward: 0 given"),
        ({"guess_rate": 2}, "guess_rate: 2 given; allowed: 0 to 1"),
        ({"hidden": "spot"}, "hidden: 'spot' given, which is no draw"),
        ({"frozen_cue": 1}, "frozen_cue: 1 given; allowed: True, False"),
    ],
)
def test_bad_facts_are_refused(facts, message):
    assert message in build_of(lambda t: None, **facts)


def test_declarations_end_with_build():
    task = ColumnsByHand(Everything).task
    for declare in (
        lambda: task.remember("late"),
        lambda: task.add_prop(kit.Cube("late")),
        lambda: task.add_state("late", text=""),
        lambda: task.draw_integer("late", 0, 1, text=""),
    ):
        with pytest.raises(engram.BadStateError, match="outside of build"):
            declare()
