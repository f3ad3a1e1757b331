"""Helpers that place, hide, move, paint and measure props."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from task_columns import ColumnsByHand

import engram
from engram import kit
from engram.kit.props import Prop

UPRIGHT = [1, 0, 0, 0]


class Table(engram.Task):
    answer = "a cube"

    def build(self):
        self.lamp = self.add_prop(kit.LampBulb("lamp"))
        self.cubes = self.add_props(kit.Cube(f"cube_{i}", half_size=0.02) for i in range(3))
        self.tray = self.add_prop(kit.ButtonCap("cap"))
        self.shape = self.add_prop(kit.Shape("star", shape="star"))
        self.draw_integer("target", 0, 2, text="a cube")

    def advance(self):
        pass

    def evaluate(self):
        pass

    def reward(self):
        return np.zeros(self.n)


@pytest.fixture
def columns():
    made = ColumnsByHand(Table)
    made.reset(target=[0, 1, 2, 0])
    made.task.moved[:] = 0
    return made


MASK = np.array([True, False, True, False])


def test_place_one_prop(columns):
    task = columns.task
    task.prop_qvel[:] = 1
    task.place(task.cubes[0], (0.1, 0.2, 0.3), where=MASK)
    assert task.prop_pos[0, 1].tolist() == [0.1, 0.2, 0.3]
    assert task.prop_pos[1, 1].tolist() == [0, 0, kit.HIDDEN_HEIGHT]
    assert task.prop_status[:, 1].tolist() == [1, 0, 1, 0]
    assert task.moved[:, 1].tolist() == MASK.tolist()
    assert not task.moved[:, [0, 2, 3, 4, 5]].any()
    assert task.prop_qvel[0, 1].tolist() == [0] * 6
    each = np.arange(12.0).reshape(4, 3)
    task.place(task.cubes[0], each, where=MASK, awake=True, velocity=(1, 2, 3), spin=each)
    assert task.prop_pos[2, 1].tolist() == [6, 7, 8]
    assert task.prop_qvel[2, 1].tolist() == [1, 2, 3, 6, 7, 8]
    assert task.prop_status[:, 1].tolist() == [2, 0, 2, 0]


def test_place_another_prop_in_every_environment(columns):
    task = columns.task
    task.place(task.cubes[task.target], (0, 0), where=MASK)
    assert task.prop_status[:, 1:4].tolist() == [[1, 0, 0], [0, 0, 0], [0, 0, 1], [0, 0, 0]]
    assert task.prop_pos[2, 3].tolist() == [0, 0, 0.02]
    each = np.arange(8.0).reshape(4, 2)
    task.place(task.cubes[task.target], each)
    assert task.pos_of(task.cubes[task.target]).tolist() == [[*xy, 0.02] for xy in each]


def test_place_a_group(columns):
    task = columns.task
    each = np.arange(24.0).reshape(4, 3, 2)
    task.place(task.cubes, each, where=MASK)
    assert task.prop_pos[2, 1:4].tolist() == [[*xy, 0.02] for xy in each[2]]
    assert task.prop_pos[1, 1:4].tolist() == [[0, 0, kit.HIDDEN_HEIGHT]] * 3
    task.place(task.cubes, [[0, 0, 1], [0, 0, 2], [0, 0, 3]])
    assert task.prop_pos[:, 1:4, 2].tolist() == [[1, 2, 3]] * 4
    task.place(task.cubes, (0, 0, 5))
    assert (task.prop_pos[:, 1:4, 2] == 5).all()
    assert task.pos_of(task.cubes).base is not None


def test_props_stand_upright_on_the_table(columns):
    task = columns.task
    task.place(task.tray, (0.1, 0.2))
    assert task.prop_pos[0, 4].tolist() == [0.1, 0.2, 0.044]
    assert task.prop_quat[0, 4, 0] == pytest.approx(np.sqrt(0.5))
    task.place(task.tray, (0.1, 0.2), UPRIGHT)
    assert task.prop_quat[0, 4].tolist() == UPRIGHT
    with pytest.raises(engram.InvalidArgumentError, match="needs a height"):
        task.place(task.shape, (0, 0))


def test_hide_and_move(columns):
    task = columns.task
    task.place(task.cubes, (0, 0))
    task.moved[:] = 0
    task.hide(task.cubes, where=MASK, pos=(1, 2, 3))
    assert task.prop_status[:, 1:4].tolist() == [[0] * 3, [1] * 3] * 2
    assert task.prop_pos[0, 1].tolist() == [1, 2, 3]
    task.hide(task.lamp)
    assert task.prop_pos[3, 0].tolist() == [0, 0, kit.HIDDEN_HEIGHT]
    task.place(task.tray, (0, 0, 0.1))
    task.moved[:] = 0
    task.move(task.tray, (0.01, 0, 0.1), where=MASK)
    assert task.prop_qvel[0, 4].tolist() == [0.01, 0, 0, 0, 0, 0]
    assert task.prop_pos[0, 4].tolist() == [0, 0, 0.1]  # the engine moves it
    assert task.prop_status[:, 4].tolist() == [2, 1, 2, 1]
    assert not task.moved.any()
    task.forget_contacts(task.tray, where=MASK)
    assert task.moved[:, 4].tolist() == [2, 0, 2, 0]


def test_paint(columns):
    task = columns.task
    task.paint(task.lamp, "yellow", where=MASK, emission=0.5)
    assert task.prop_rgba[:, 0].tolist() == [[1, 1, 0, 1], [0] * 4] * 2
    assert task.prop_emission[:, 0].tolist() == [0.5, 0, 0.5, 0]
    task.paint(task.lamp, None)
    assert not task.prop_rgba.any()
    each = np.eye(4)
    task.paint(task.lamp, each, where=MASK)
    assert task.prop_rgba[2, 0].tolist() == [0, 0, 1, 0]
    with pytest.raises(engram.InvalidArgumentError, match="'yelow' given; did you mean 'yellow'"):
        task.paint(task.lamp, "yelow")


def test_nothing_happens_without_environments(columns):
    task = columns.task
    before = {name: column.copy() for name, column in columns.all.items()}
    nowhere = np.zeros(4, bool)
    task.place(task.cubes, (0, 0), where=nowhere)
    task.hide(task.cubes, where=nowhere)
    task.paint(task.cubes, "red", where=nowhere)
    task.give_answer(1, True, nowhere)
    assert all((before[name] == column).all() for name, column in columns.all.items())


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda t: t.place(t.lamp, np.zeros((3, 3))), r"place: pos: shape \(3, 3\) given; \(3,\)"),
        (lambda t: t.place(t.cubes, np.zeros((4, 3))), r"shape \(4, 3\) given; \(3, 3\) or"),
        (lambda t: t.place(t.lamp, (0, 0, 0), (1, 0, 0)), r"quat: shape \(3,\) given; \(4,\)"),
        (lambda t: t.place(t.lamp, (0, 0), where=MASK[:3]), r"where: bool of shape \(3,\) given"),
        (lambda t: t.hide(t.lamp, where=np.zeros(4, int)), "where: int64 of shape"),
        (lambda t: t.hide(np.zeros(3, int)), r"props: int64 of shape \(3,\) given"),
    ],
)
def test_bad_arguments_are_refused(columns, call, message):
    with pytest.raises(engram.InvalidArgumentError, match=message):
        call(columns.task)


def test_measures(columns):
    task = columns.task
    columns.all["tcp_pos"][:] = (0, 0, 0.3)
    task.place(task.cubes, [[0, 0, 0], [0.4, 0, 0.3], [0, 0, 0.25]])
    assert (
        task.tcp_distance(task.pos_of(task.cubes)).tolist() == [pytest.approx([0.3, 0.4, 0.05])] * 4
    )
    assert task.tcp_distance(task.pos_of(task.cubes[1])).tolist() == [pytest.approx(0.4)] * 4
    assert task.nearest(task.pos_of(task.cubes), 0.06).tolist() == [2] * 4
    assert task.nearest(task.pos_of(task.cubes), 0.06, where=MASK).tolist() == [2, -1, 2, -1]
    assert task.nearest(task.pos_of(task.cubes), 0.04).tolist() == [-1] * 4
    columns.all["qvel"][1, 6] = -0.21
    columns.all["qvel"][2, 7] = 3  # a finger
    assert task.robot_is_static().tolist() == [True, False, True, True]
    assert task.robot_is_static(0.3).all()
    task.prop_qvel[1, 1, 0] = 0.02
    task.prop_qvel[2, 2, 5] = 0.2
    assert task.prop_is_static(task.cubes[0]).tolist() == [True, False, True, True]
    assert task.prop_is_static(task.cubes)[2].tolist() == [True, False, True]
    assert task.prop_is_static(task.cubes[task.target]).all()


def test_the_first_answer_counts(columns):
    task = columns.task
    task.give_answer(task.target, task.target == 2, MASK)
    assert task.answered.tolist() == MASK.tolist()
    assert task.first_answer.tolist() == [0, 0, 2, 0]
    task.give_answer(1, True, np.ones(4, bool))
    assert task.first_answer.tolist() == [0, 1, 2, 1]
    assert task.first_answer_correct.tolist() == [False, True, True, True]


def test_caps_sink_by_their_travel_and_are_pressed(columns):
    task = columns.task
    task.place(task.tray, (0.1, 0.2))
    tool = columns.all["tcp_pos"]
    tool[:] = [(0.1, 0.2, 0.3), (0.1, 0.2, 0.084), (0.1, 0.2, 0.07), (0.1, 0.27, 0.07)]
    columns.call("advance")
    assert task.press_depth(task.tray) == pytest.approx([0, 0.004, 0.01, 0])
    assert task.pressed(task.tray).tolist() == [False, True, True, False]
    assert task.pressed(task.tray, share=0.5).tolist() == [False, False, True, False]
    assert task.prop_pos[:, task.tray, 2] == pytest.approx([0.044, 0.04, 0.034, 0.044])
    # Away and back up; placed anew while the tool is there; hidden.
    tool[2] = (0, 0, 0.3)
    columns.call("advance")
    assert task.prop_pos[2, task.tray, 2] == 0.044
    task.place(task.tray, (0.1, 0.2))
    columns.call("advance")
    assert task.prop_pos[:, task.tray, 2] == pytest.approx([0.044, 0.04, 0.044, 0.044])
    task.hide(task.tray)
    columns.call("advance")
    assert not task.pressed(task.tray).any()
    with pytest.raises(engram.InvalidArgumentError, match="'cube_1' given"):
        task.pressed(task.cubes[1])


def test_the_page_has_all_props_and_their_heights():
    page = (Path(__file__).parents[3] / "docs" / "custom_tasks.md").read_text()
    rows = [line.split(" | ") for line in page.splitlines() if line.startswith("| `")]
    heights = {row[0].strip("| `"): row[3] for row in rows if len(row) == 5}
    kinds = [one for one in vars(kit).values() if isinstance(one, type) and issubclass(one, Prop)]
    kinds.remove(Prop)
    assert len(kinds) == 19
    for kind in kinds:
        given = (
            {"vertices": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]} if kind is kit.Mesh else {}
        )
        height = kind("prop", **given).resting_height
        shown = heights[kind.__name__].split(",")[0]
        if kind is not kit.Mesh:
            assert "needs z" in shown if height is None else float(shown) == height, kind
