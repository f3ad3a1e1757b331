"""KeepTrack: lamps change their colours again and again; which colour had this one last?

One lamp of a row lights up at a time, in some colour, many times. Then all are dark, one of them
lights up in white, and the cube in the colour that it had last has to be touched. A colour may be
the latest one of its lamp for a long time or for a moment: each new one makes an older one wrong
(proactive interference), and those of the other lamps come in between (retroactive).

    python -m engram eval keep_track.py:KeepTrack4-v0 --policy oracle
"""

from __future__ import annotations

import numpy as np

import engram
from engram import kit

GOAL_THRESH = 0.05  # m
TOUCH = (0, 0, 0.037)  # m: from a cube to where the tool touches it
DARK = (0.2, 0.2, 0.2)


def row(count, x, distance):
    return [(x, distance * (i - (count - 1) / 2)) for i in range(count)]


class KeepTrack(engram.Task):
    LAMPS = kit.Integer(4, low=2, high=8, text="lamps in a row")
    COLORS = kit.Integer(5, low=2, high=6, text="colours, each of a cube")
    UPDATES = kit.Integer(48, low=6, high=200, text="how often a lamp lights up")
    LIT_STEPS = kit.Integer(3, low=1, high=20, unit="control steps", text="how long each time")
    EMPTY_PHASE_STEPS = kit.Steps(5, 20, text="how long all lamps are dark then")

    memory_type = "Object"
    frozen_cue = True
    hidden = "color"
    answer = "the first cube within 5 cm of which the robot rests"
    time_to_act = 20

    def build(self):
        lamps, colors, updates = self.LAMPS, self.COLORS, self.UPDATES
        self.candidates = colors
        self.period = self.LIT_STEPS + 2
        self.spots = np.array(row(colors, 0.05, 0.11))
        self.palette = np.array(list(kit.COLORS.values())[:colors])
        self.lamps = self.add_props(
            kit.Cylinder(f"lamp_{i}", radius=0.03, half_height=0.01, color=DARK, body="kinematic",
                         object="lamp")
            for i in range(lamps)
        )  # fmt: skip
        self.cubes = self.add_props(
            kit.Cube(f"cube_{color}", color=color) for color in list(kit.COLORS)[:colors]
        )

        self.draw_integer("asked", 0, lamps - 1, text="the lamp that is asked for")
        self.draw_integer("color", 0, colors - 1, text="the colour that it had last")
        self.draw_integer("last_turn", updates // 6, updates - 1, text="when it had that")
        self.draw_integer("lamp_draws", 0, lamps - 1, width=updates, text="lamp of a turn")
        self.draw_integer(
            "detours", 1, lamps - 1, width=updates, text="lamps on from the asked one"
        )
        self.draw_integer("color_draws", 0, colors - 1, width=updates, text="colour of a turn")
        self.draw_order("places", colors, text="where the cubes appear")
        self.draw_range("empty_steps", "EMPTY_PHASE_STEPS")
        self.remember("lamp_at", width=updates, low=0, high=lamps - 1, text="lamp of a turn")
        self.remember("color_at", width=updates, low=0, high=colors - 1, text="colour of a turn")
        self.add_phases(("cue", updates * self.period), ("empty", "empty_steps"), "act")
        self.add_state("color", text="the cube to touch")
        self.add_state("goal_pos", 3, unit="m", text="where it is")

    @property
    def goal(self):
        return self.pos_of(self.cubes[self.color])

    def reset(self):
        """After its last turn, others light up in the place of the lamp that is asked for."""
        self.place(self.lamps, row(self.LAMPS, -0.12, 0.13))
        asked = self.asked[:, None]
        over = (np.arange(self.UPDATES) > self.last_turn[:, None]) & (self.lamp_draws == asked)
        self.lamp_at[:] = np.where(over, (asked + self.detours) % self.LAMPS, self.lamp_draws)
        self.color_at[:] = self.color_draws
        self.lamp_at[self.rows, self.last_turn] = self.asked
        self.color_at[self.rows, self.last_turn] = self.color

    def advance(self):
        turn, step = np.divmod(self.elapsed, self.period)
        lights = turn < self.UPDATES
        turn = np.minimum(turn, self.UPDATES - 1)
        lamp = self.lamps[self.lamp_at[self.rows, turn]]
        color = self.palette[self.color_at[self.rows, turn]]
        self.paint(lamp, color, where=lights & (step == 0), emission=0.6)
        self.paint(lamp, None, where=lights & (step == self.LIT_STEPS), emission=0)
        asks = self.begins("act")
        self.paint(self.lamps[self.asked], (1, 1, 1), where=asks, emission=0.6)
        self.place(self.cubes, self.spots[self.places], where=asks)

    def evaluate(self):
        acts = self.in_phase("act")
        self.answer_by_touch(self.pos_of(self.cubes), self.color, GOAL_THRESH, where=acts)

    def reward(self):
        near = 1 - kit.tanh(10 * self.tcp_distance(self.goal))
        return np.where(self.success, 1, 0.5 * near)

    def observe(self):
        return {"color": self.color, "goal_pos": self.goal}

    def oracle(self):
        self.touch_cube(self.color)

    def blind(self):
        self.touch_cube(self.guess(self.COLORS))

    def touch_cube(self, key):
        self.rest()
        self.touch(self.pos_of(self.cubes[key]) + TOUCH, where=self.in_phase("act"))

    def sweep(self):
        self.rest()
        self.tour(self.pos_of(self.cubes) + TOUCH, where=self.in_phase("act"))


INSTRUCTION = (
    "Watch the lamps change their colors, wait, then touch the cube in the color that the white "
    "lamp had last."
)
engram.register_task(KeepTrack, "KeepTrack4-v0", 285, INSTRUCTION)
