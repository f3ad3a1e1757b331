"""RememberColor9 once more, written with engram.Task.

A cube is shown, the table is empty for a while, then nine cubes appear: touch the one that was
shown. With the same draws and actions, success and rewards are those of RememberColor9-VLA-v0.

    python -m engram eval remember_color.py:MyRememberColor9-v0 --policy oracle
"""

from __future__ import annotations

import numpy as np

import engram
from engram import kit

TOUCH = (0, 0, 0.037)  # m: from a cube to where the tool touches it


class RememberColor(engram.Task):
    COLORS = kit.Integer(9, low=2, high=9, text="cubes, each of another colour")
    CUE_PHASE_STEPS = kit.Steps(1, 5, text="how long the cue is shown")
    EMPTY_PHASE_STEPS = kit.Steps(1, 5, text="how long the table is empty then")
    GOAL_THRESH = kit.Real(0.05, low=0.045, high=0.2, unit="m", text="how near a touch has to be")

    success_reward = 3.0
    frozen_cue = True
    hidden = "target"
    answer = "the first cube within GOAL_THRESH of which the robot rests"
    time_to_act = 15

    def build(self):
        self.candidates = self.COLORS
        colors = list(kit.COLORS)[: self.COLORS]
        self.cubes = self.add_props(kit.Cube(f"cube_{color}", color=color) for color in colors)
        self.draw_integer("target", 0, self.COLORS - 1, text="the cube to touch")
        self.draw_places(
            "positions", self.COLORS, (-0.2, -0.25), (0.05, 0.25), least_distance=0.07,
            text="where the cubes appear",
        )  # fmt: skip
        self.draw_range("cue_steps", "CUE_PHASE_STEPS")
        self.draw_range("empty_steps", "EMPTY_PHASE_STEPS")
        self.add_phases(("cue", "cue_steps"), ("empty", "empty_steps"), "act")
        self.add_state("target", text="the cube to touch")
        self.add_state("goal_pos", 3, unit="m", text="where it is")

    @property
    def goal(self):
        return self.pos_of(self.cubes[self.target])

    def advance(self):
        self.place(self.cubes[self.target], (0, 0), where=self.in_phase("cue"))
        self.hide(self.cubes, where=self.begins("empty"))
        self.forget_contacts(self.cubes, where=self.in_phase("act"))  # as the built-in task
        self.place(self.cubes, self.positions, where=self.begins("act"))

    def evaluate(self):
        acts = self.in_phase("act")
        self.answer_by_touch(self.pos_of(self.cubes), self.target, self.GOAL_THRESH, where=acts)

    def reward(self):
        away = self.tcp_distance(self.goal)
        rests_there = self.robot_is_static() & (away <= self.GOAL_THRESH)
        still = 1 - kit.tanh(5 * kit.length(self.qvel[:, :7]))
        shaped = 1 - kit.tanh(10 * away) + 0.5 * still + 0.5 * rests_there
        return np.where(self.success, 3, shaped - self.smoothness_penalty(0.02, 0.05, 0.01))

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


engram.register_task(
    RememberColor,
    "MyRememberColor9-v0",
    horizon=25,
    instruction="Observe the cube's color, wait, then touch the cube of the same color.",
)
