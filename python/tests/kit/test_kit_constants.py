"""Constants of users' tasks: bounds, definitions, values on instances."""

from __future__ import annotations

import pytest
from task_columns import ColumnsByHand

import engram
from engram import kit
from engram.kit.constants import constants_of


class Lamps(engram.Task):
    LAMPS = kit.Integer(3, low=2, high=5, text="lamps")
    WAIT = kit.Steps(1, 5, text="how long to wait")
    REACH = kit.Real(0.05, low=0.01, high=0.1, unit="m", text="how near")
    SPEED = kit.RealRange(0.1, 0.2, low=0, high=1, unit="m/s", text="how fast")
    SHAPE = kit.Name("cube", names=("cube", "sphere"), text="which shape")
    SIZE = kit.Fixed(0.02, unit="m")


def test_definitions_are_what_the_engine_takes():
    listed = {name: one.definition(name) for name, one in constants_of(Lamps).items()}
    assert list(listed) == ["LAMPS", "WAIT", "REACH", "SPEED", "SHAPE", "SIZE"]
    assert listed["LAMPS"] == {
        "name": "LAMPS", "kind": "integer", "value": 3, "low": 2, "high": 5, "unit": "",
        "text": "lamps",
    }  # fmt: skip
    assert listed["WAIT"]["kind"] == "integer_range"
    assert listed["WAIT"]["value"] == [1, 5]
    assert listed["WAIT"]["unit"] == "control steps"
    assert listed["SPEED"]["kind"] == "real_range"
    assert listed["SHAPE"]["names"] == ["cube", "sphere"]
    assert listed["SIZE"]["value"] == 0.02


def test_instances_have_plain_values():
    task = ColumnsByHand(Lamps).task
    assert (task.LAMPS, task.WAIT, task.REACH, task.SHAPE) == (3, (1, 5), 0.05, "cube")
    changed = ColumnsByHand(Lamps, LAMPS=5, WAIT=[2, 2], SPEED=[0.5, 0.5]).task
    assert (changed.LAMPS, changed.WAIT, changed.SPEED) == (5, (2, 2), (0.5, 0.5))
    assert isinstance(Lamps.LAMPS, kit.Integer)


def test_a_subclass_changes_and_adds_constants():
    class More(Lamps):
        LAMPS = kit.Integer(4, low=2, high=5, text="lamps")
        REACH = 0.03
        EXTRA = kit.Fixed(1)

    assert set(constants_of(More)) == {"LAMPS", "WAIT", "SPEED", "SHAPE", "SIZE", "EXTRA"}
    assert ColumnsByHand(More).task.LAMPS == 4
    assert ColumnsByHand(More).task.REACH == 0.03


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: kit.Integer(9, low=2, high=5, text=""), "value: 9 given; allowed: 2 to 5"),
        (lambda: kit.Integer(2.5, low=2, high=5, text=""), "value: 2.5 given, an integer"),
        (lambda: kit.Integer(3, low=5, high=2, text=""), "low: 5 given; at most high"),
        (lambda: kit.Real(0.5, low=0, high=0.1, text=""), "value: 0.5 given; allowed: 0 to 0.1"),
        (lambda: kit.Steps(5, 1, text=""), "least: 5 given; at most greatest"),
        (lambda: kit.Steps(0, 1, text=""), "least: 0 given; allowed: 1"),
        (lambda: kit.Name("cone", names=("cube",), text=""), "'cone' given; allowed: cube"),
        (lambda: kit.Integer(3, low=2, high=5, text=3), "text: 3 given, a string"),
    ],
)
def test_bad_constants_are_refused(make, message):
    with pytest.raises(engram.InvalidArgumentError, match=message):
        make()
