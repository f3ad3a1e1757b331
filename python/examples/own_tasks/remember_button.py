"""One of three buttons is lit for a moment: press it once all of them look the same again.

python -m engram eval remember_button.py:RememberButton3-v0 --policy oracle
"""

from __future__ import annotations

import numpy as np

import engram
from engram import kit

PLACES = np.array([(-0.05, -0.2), (-0.05, 0.0), (-0.05, 0.2)])  # m
PRESS = (0, 0, 0.059)  # m: from a base to where the tool presses its cap


class RememberButton(engram.Task):
    CUE_PHASE_STEPS = kit.Steps(1, 5, text="how long a button is lit")
    EMPTY_PHASE_STEPS = kit.Steps(1, 5, text="how long none is lit then")

    termination = "success_or_failed"
    frozen_cue = True
    candidates = 3
    hidden = "target"
    answer = "the first button that is pressed"
    question = "Which button is to be pressed?"
    choices = ("the left button", "the middle button", "the right button")
    time_to_act = 25

    def build(self):
        places = range(len(PLACES))
        self.bases = self.add_props(kit.ButtonBase(f"base_{i}") for i in places)
        self.caps = self.add_props(kit.ButtonCap(f"cap_{i}", travel=0.014) for i in places)
        self.draw_integer("target", 0, 2, text="the button that is lit")
        self.draw_range("cue_steps", "CUE_PHASE_STEPS")
        self.draw_range("empty_steps", "EMPTY_PHASE_STEPS")
        self.add_phases(("cue", "cue_steps"), ("empty", "empty_steps"), "act")
        self.add_state("target", text="the button that was lit")
        self.add_state("depth", 3, unit="m", text="how far each cap has sunk")

    def reset(self):
        self.place(self.bases, PLACES)
        self.place(self.caps, PLACES)

    def advance(self):
        lit = self.caps[self.target]
        self.paint(lit, "yellow", emission=1.0, where=self.in_phase("cue"))
        self.paint(lit, None, emission=0.0, where=self.begins("empty"))

    def evaluate(self):
        pressed = self.pressed(self.caps) & self.in_phase("act")[:, None]
        button = pressed.argmax(axis=1)
        right = button == self.target
        self.success[:] = pressed.any(axis=1) & right
        self.failed[:] = pressed.any(axis=1) & ~right
        self.give_answer(button, right, pressed.any(axis=1))

    def reward(self):
        away = self.tcp_distance(self.pos_of(self.bases[self.target]) + PRESS)
        near = (0.5 - 0.5 * kit.tanh(5 * away)) * self.in_phase("act")
        return np.where(self.success, 1, near)

    def observe(self):
        return {"target": self.target, "depth": self.press_depth(self.caps)}

    def oracle(self):
        self.press(self.target)

    def blind(self):
        self.press(self.guess_choice())

    def press(self, button):
        self.rest()
        above = self.pos_of(self.bases[button]) + PRESS
        self.touch(above, where=self.in_phase("act"))

    def sweep(self):
        self.rest()
        self.tour(self.pos_of(self.bases) + PRESS, where=self.in_phase("act"))


engram.register_task(RememberButton, "RememberButton3-v0", 60,
                     "Watch which button lights up, wait, then press it.")  # fmt: skip
