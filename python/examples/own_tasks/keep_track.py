"""KeepTrack: lamps light up in changing colours; which one had this colour last?

A row of lamps. Again and again one of them lights up for a moment, in some colour, so that what
was right a moment ago is wrong now. Then all are dark, a disc appears in one colour, and the lamp
that had it last has to be touched. What has to be remembered is one colour for every lamp; what
makes it hard are the many colours that no longer count (proactive interference).

    python -m engram eval keep_track.py:KeepTrack4-v0 --policy oracle
"""

from __future__ import annotations

import numpy as np

import engram
from engram import kit

GOAL_THRESH = 0.05  # m
TOUCH = (0, 0, 0.03)  # m: from a lamp to where the tool touches it
PROBE = (0.1, 0.0)  # m: where the disc appears


class KeepTrack(engram.Task):
    LAMPS = kit.Integer(4, low=2, high=6, text="lamps, and colours")
    UPDATES = kit.Integer(24, low=6, high=200, text="how often a lamp lights up")
    LIT_STEPS = kit.Integer(3, low=1, high=20, unit="control steps", text="how long each time")
    EMPTY_PHASE_STEPS = kit.Steps(5, 20, text="how long all lamps are dark then")

    memory_type = "Object"
    success_reward = 1.0
    frozen_cue = True
    hidden = "asked"
    answer = "the first lamp within 5 cm of which the robot rests"
    time_to_act = 20

    def build(self):
        lamps, updates = self.LAMPS, self.UPDATES
        self.candidates = lamps
        self.period = self.LIT_STEPS + 2
        self.palette = np.array(list(kit.COLORS.values())[:lamps])
        self.lamps = self.add_props(
            kit.Cylinder(
                f"lamp_{i}", radius=0.03, half_height=0.01, color=(0.2, 0.2, 0.2), body="kinematic",
                object="lamp",
            )
            for i in range(lamps)
        )  # fmt: skip
        self.probe = self.add_prop(kit.TargetDisc("probe", radius=0.04, color=(1, 1, 1)))
        self.places = [(-0.05, 0.13 * (i - (lamps - 1) / 2)) for i in range(lamps)]

        self.draw_integer("asked", 0, lamps - 1, text="the lamp to touch")
        self.draw_order("last_colors", lamps, text="the colour that each lamp has last")
        self.draw_integer("lamp_draws", 0, lamps - 1, width=updates, text="lamps that light up")
        self.draw_integer("color_draws", 0, lamps - 1, width=updates, text="their colours")
        self.draw_choice("turns", lamps, updates, text="a turn that each lamp has for sure")
        self.draw_range("empty_steps", "EMPTY_PHASE_STEPS")
        self.remember("lamp_at", width=updates, low=0, high=lamps - 1, text="lamp of a turn")
        self.remember("color_at", width=updates, low=0, high=lamps - 1, text="colour of a turn")
        self.add_phases(("cue", updates * self.period), ("empty", "empty_steps"), "act")
        self.add_state("asked", text="the lamp to touch")
        self.add_state("goal_pos", 3, unit="m", text="where it is")

    @property
    def goal(self):
        return self.pos_of(self.lamps[self.asked])

    def reset(self):
        self.place(self.lamps, self.places)
        self.lamp_at[:] = self.lamp_draws
        self.lamp_at[self.rows[:, None], self.turns] = np.arange(self.LAMPS)
        self.color_at[:] = self.color_draws
        for lamp in range(self.LAMPS):
            last = self.UPDATES - 1 - (self.lamp_at[:, ::-1] == lamp).argmax(axis=1)
            self.color_at[self.rows, last] = self.last_colors[:, lamp]

    def advance(self):
        turn, step = np.divmod(self.elapsed, self.period)
        lights = turn < self.UPDATES
        turn = np.minimum(turn, self.UPDATES - 1)
        lamp = self.lamps[self.lamp_at[self.rows, turn]]
        color = self.palette[self.color_at[self.rows, turn]]
        self.paint(lamp, color, where=lights & (step == 0), emission=0.6)
        self.paint(lamp, None, where=lights & (step == self.LIT_STEPS), emission=0)
        asks = self.begins("act")
        self.place(self.probe, PROBE, where=asks)
        asked_color = self.last_colors[self.rows, self.asked]
        self.paint(self.probe, self.palette[asked_color], where=asks)

    def evaluate(self):
        acts = self.in_phase("act")
        self.answer_by_touch(self.pos_of(self.lamps), self.asked, GOAL_THRESH, where=acts)

    def reward(self):
        near = 1 - kit.tanh(10 * self.tcp_distance(self.goal))
        return np.where(self.success, 1, 0.5 * near)

    def observe(self):
        return {"asked": self.asked, "goal_pos": self.goal}

    def oracle(self):
        self.touch_lamp(self.asked)

    def blind(self):
        self.touch_lamp(self.guess(self.LAMPS))

    def touch_lamp(self, lamp):
        self.rest()
        self.touch(self.pos_of(self.lamps[lamp]) + TOUCH, where=self.in_phase("act"))

    def sweep(self):
        self.rest()
        self.tour(self.pos_of(self.lamps) + TOUCH, where=self.in_phase("act"))


INSTRUCTION = (
    "Watch the lamps change their colors, wait, then touch the lamp that had the color of the disc "
    "last."
)
engram.register_task(KeepTrack, "KeepTrack4-v0", 165, INSTRUCTION)
