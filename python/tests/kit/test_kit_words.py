"""Episodes in words of tasks in Python: plan, subtask, memory, and names of draws."""

from __future__ import annotations

from contextlib import closing

import numpy as np
import pytest

import engram
from engram import kit

COLORS = ("red", "green", "blue")


class Recall(engram.Task):
    hidden = "target"

    def build(self):
        self.candidates = 3
        self.cubes = self.add_props(kit.Cube(f"cube_{color}", color=color) for color in COLORS)
        self.draw_integer("target", 0, 2, text="the cube to touch", names=COLORS)
        self.draw_order("order", 3, text="how they stand", names=COLORS)
        self.add_phases(("cue", 3), "act")
        self.add_subtasks(
            "watch", "touch the {target} cube of {order}", memory="the cube was {target}"
        )

    def advance(self):
        acts = self.in_phase("act")
        self.shown[:] |= self.elapsed >= 1
        self.subtask[:] = acts
        self.meant[:] = np.where(acts, self.cubes[self.target], -1)

    def evaluate(self):
        self.success[:] = self.elapsed >= 6

    def reward(self):
        return self.success * 1.0


def words_after(steps, env):
    env.reset(seed=4)
    for _ in range(steps):
        env.step(env.act("zero"))
    return env.words()[1]


def test_words_follow_the_columns_and_do_not_tell_what_has_not_been_shown():
    engram.register_task(Recall, "Recall-v0", 10, "Touch the cube; they stand as {order}.")
    pins = {"target": [2], "order": [1, 2, 0]}
    with closing(engram.make_vec("Recall-v0", 2, pins=pins, autoreset_mode="DISABLED")) as env:
        first = words_after(0, env)
        row = "green, blue, red"
        assert first["plan"] == ["watch", f"touch the right cube of {row}"]
        assert (first["memory"], first["object"], first["subtask"]) == ("", None, 0)
        assert env.instructions[0].endswith(f"they stand as {row}.")
        shown = words_after(2, env)
        assert shown["plan"][1] == f"touch the blue cube of {row}"
        assert (shown["memory"], shown["subtask"]) == ("the cube was blue", 0)
        acts = words_after(4, env)
        assert (acts["object"], acts["subtask"], acts["subtasks_done"]) == ("cube_blue", 1, 1)
        state = env.save(1)
        assert words_after(7, env)["subtasks_done"] == 2
        env.restore(state, 1)
        assert env.words()[1] == acts


def test_tasks_without_subtasks_have_no_words():
    class Silent(Recall):
        def build(self):
            self.cube = self.add_prop(kit.Cube("cube"))
            self.draw_integer("target", 0, 2, text="nothing")

        def advance(self):
            pass

    engram.register_task(Silent, "Silent-v0", 10, "Wait.")
    with closing(engram.make_vec("Silent-v0", 1)) as env:
        env.reset(seed=1)
        with pytest.raises(engram.UnavailableError, match="has no words"):
            env.words()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t: t.draw_integer("a", 1, 3, text="", names=["x"]), "1 given; 3, one for each"),
        (lambda t: t.draw_order("a", 2, text="", names=[1, 2]), "names"),
        (lambda t: t.add_subtasks(), "one or more"),
        (lambda t: t.add_subtasks("a") or t.add_subtasks("b"), "in one call"),
        (lambda t: t.remember("shown", bool) or t.add_subtasks("a"), "declared already"),
    ],
)
def test_mistakes_are_named(change, message):
    class Wrong(Recall):
        def build(self):
            change(self)

    with pytest.raises(engram.InvalidArgumentError, match=message):
        Wrong("Wrong-v0", 10, {})
