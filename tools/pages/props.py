"""Draws docs/pictures/kit_props.png: all props of engram.kit, with their usual sizes."""

import argparse

import numpy as np
from measurements.common import ROOT
from PIL import Image

import engram
from engram import kit

SIZE = (1600, 1000)  # pixels
SHOWN = (slice(420, 790), slice(430, 1150))  # rows and columns
ROOF = [(x, y, 0) for x in (-0.02, 0.02) for y in (-0.03, 0.03)] + [
    (0, -0.03, 0.04),
    (0, 0.03, 0.04),
]
PARTS = (
    kit.Geom("box", (0.03, 0.03, 0.005), color="olive"),
    kit.Geom("cylinder", (0.01, 0.03), pos=(0, 0, 0.035), color="red"),
)
# Rows from the camera on, in the order of the page; x of each row and y of each prop, m.
ROWS = {
    0.16: (
        (kit.Cube("cube", color="red"), -0.24),
        (kit.Box("box", color="green"), -0.16),
        (kit.Sphere("sphere", color="blue"), -0.08),
        (kit.Cylinder("cylinder", color="yellow"), 0),
        (kit.Mesh("mesh", vertices=ROOF, color="teal"), 0.08),
        (kit.Shape("shape", shape="star", color="magenta"), 0.16),
        (kit.Ball("ball", color="cyan"), 0.24),
    ),
    0.03: (
        (kit.Parts("parts", PARTS, body="kinematic"), -0.28),
        (kit.TargetDisc("target_disc"), -0.16),
        (kit.Disc("disc", color="green"), -0.03),
        (kit.Mug("mug"), 0.13),
        (kit.Peg("peg"), 0.3),
    ),
    -0.15: (
        (kit.Battery("battery"), -0.42),
        (kit.BatteryTray("tray", slots=[(0, -0.03), (0, 0.03)]), -0.26),
        (kit.BatterySocket("socket"), -0.04),
        (kit.ButtonBase("base"), 0.15),
        (kit.ButtonCap("cap"), 0.15),
        (kit.LampBody("stand"), 0.3),
        (kit.LampBulb("bulb"), 0.3),
    ),
}
HEIGHTS = {"shape": 0.02, "parts": 0.005}  # m, of props that need one


class AllProps(engram.Task):
    def build(self):
        for row in ROWS.values():
            for prop, _ in row:
                self.add_prop(prop)

    def reset(self):
        places = [(prop.name, x, y) for x, row in ROWS.items() for prop, y in row]
        for i, (name, x, y) in enumerate(places):
            self.place(i, (x, y, HEIGHTS[name]) if name in HEIGHTS else (x, y))

    def evaluate(self):
        pass

    def reward(self):
        return np.zeros(self.n)


def main(words, program):
    argparse.ArgumentParser(prog=program, description=__doc__).parse_args(words)
    engram.register_task(AllProps, "AllProps-v0", 10, "Look.")
    env = engram.make_vec("AllProps-v0", 1, threads=1, shadows=True)
    env.reset(seed=0)
    picture = env.frame(camera="base_camera", size=SIZE)
    Image.fromarray(picture[SHOWN]).save(
        ROOT / "docs" / "pictures" / "kit_props.png", optimize=True
    )
