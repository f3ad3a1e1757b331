"""RememberColorSequence: cubes are shown one after another; touch the n-th of them.

Later all cubes stand on the table, and white marks beside them say which one is asked: one mark
for the first, two for the second, and so on. Order has to be remembered, not only which colours
there were.

    python -m engram eval remember_color_sequence.py:RememberColorSequence3-v0 --policy oracle
"""

from __future__ import annotations

import numpy as np

import engram
from engram import kit

TOUCH = (0, 0, 0.037)  # m: from a cube to where the tool touches it
GOAL_THRESH = 0.05  # m


class RememberColorSequence(engram.Task):
    LENGTH = kit.Integer(3, low=2, high=5, text="cubes that are shown")
    COLORS = kit.Integer(5, low=3, high=9, text="cubes on the table in the end")
    SHOW_STEPS = kit.Steps(2, 5, text="how long each cube is shown")
    EMPTY_PHASE_STEPS = kit.Steps(1, 5, text="how long the table is empty then")

    memory_type = "Sequence"
    success_reward = 1.0
    frozen_cue = True
    hidden = "sequence"
    answer = "the first cube within 5 cm of which the robot rests"
    time_to_act = 15

    def build(self):
        if self.LENGTH > self.COLORS:
            raise engram.InvalidArgumentError(
                f"LENGTH: {self.LENGTH} given; at most COLORS, {self.COLORS}, allowed"
            )
        self.candidates = self.COLORS
        colors = list(kit.COLORS)[: self.COLORS]
        self.cubes = self.add_props(kit.Cube(f"cube_{color}", color=color) for color in colors)
        self.marks = self.add_props(
            kit.Sphere(f"mark_{i}", radius=0.02, color=(1, 1, 1), body="visual", object="part")
            for i in range(self.LENGTH)
        )
        self.draw_choice("sequence", self.LENGTH, self.COLORS, text="the cubes that are shown")
        self.draw_integer("asked", 0, self.LENGTH - 1, text="which of them has to be touched")
        self.draw_places(
            "positions", self.COLORS, (-0.2, -0.25), (0.05, 0.25), least_distance=0.07,
            text="where the cubes appear",
        )  # fmt: skip
        self.draw_range("show_steps", "SHOW_STEPS")
        self.draw_range("empty_steps", "EMPTY_PHASE_STEPS")
        self.shown = [f"cube {i + 1}" for i in range(self.LENGTH)]
        self.add_phases(
            *[(phase, "show_steps") for phase in self.shown], ("empty", "empty_steps"), "act"
        )
        self.add_state("target", text="the cube to touch")
        self.add_state("goal_pos", 3, unit="m", text="where it is")

    @property
    def target(self):
        return self.sequence[self.rows, self.asked]

    @property
    def goal(self):
        return self.pos_of(self.cubes[self.target])

    def reset(self):
        self.cue_end[:] = self.start_of("empty")

    def advance(self):
        for i, phase in enumerate(self.shown):
            begins = self.begins(phase)
            self.hide(self.cubes, where=begins)
            self.place(self.cubes[self.sequence[:, i]], (0, 0), where=begins)
        self.hide(self.cubes, where=self.begins("empty"))
        act = self.begins("act")
        self.place(self.cubes, self.positions, where=act)
        for i, mark in enumerate(self.marks):
            self.place(mark, (0.15, 0.07 * (i - 1)), where=act & (self.asked >= i))

    def evaluate(self):
        acts = self.in_phase("act")
        self.answer_by_touch(self.pos_of(self.cubes), self.target, GOAL_THRESH, where=acts)

    def reward(self):
        near = 1 - kit.tanh(10 * self.tcp_distance(self.goal))
        return np.where(self.success, 1, 0.5 * near)

    def observe(self):
        return {"target": self.target, "goal_pos": self.goal}

    def oracle(self):
        self.touch_cube(self.target)

    def blind(self):
        self.touch_cube(self.guess(self.COLORS))

    def touch_cube(self, key):
        self.rest(gripper=kit.GRIPPER_OPEN)
        self.touch(self.pos_of(self.cubes[key]) + TOUCH, where=self.in_phase("act"))

    def sweep(self):
        self.rest()
        self.tour(self.pos_of(self.cubes) + TOUCH, where=self.in_phase("act"))


INSTRUCTION = (
    "Observe the cubes in their order, wait, then touch the one whose place in the order is the "
    "number of white marks."
)
engram.register_task(RememberColorSequence, "RememberColorSequence3-v0", 45, INSTRUCTION)
