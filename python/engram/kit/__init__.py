"""Parts of which users make tasks of their own: see ``engram.Task``.

Constants (``Integer``, ``Real``, ``Steps``, ...) are declared as class attributes, props (``Cube``,
``Sphere``, ``Button``, ...) are handed to ``Task.add_prop`` in ``Task.build``. The functions
(``sin``, ``tanh``, ``length``, ...) have the same bits on every machine.
"""

from __future__ import annotations

from engram.kit.checks import check
from engram.kit.constants import Fixed, Integer, IntegerRange, Name, Real, RealRange, Steps
from engram.kit.files import load_file, split_target
from engram.kit.functions import (
    asin,
    atan2,
    cos,
    distance,
    exp,
    hypot,
    length,
    log,
    sin,
    tan,
    tanh,
)
from engram.kit.motion import GRIPPER_CLOSED, GRIPPER_OPEN, TOOL_DOWN
from engram.kit.props import (
    COLORS,
    Ball,
    Battery,
    BatterySocket,
    BatteryTray,
    Box,
    ButtonBase,
    ButtonCap,
    Cube,
    Cylinder,
    Disc,
    Geom,
    LampBody,
    LampBulb,
    Mesh,
    Mug,
    Parts,
    Peg,
    Prop,
    Shape,
    Sphere,
    TargetDisc,
)
from engram.kit.scene import HIDDEN_HEIGHT, Props
from engram.kit.task import Task

__all__ = [
    "COLORS",
    "GRIPPER_CLOSED",
    "GRIPPER_OPEN",
    "HIDDEN_HEIGHT",
    "TOOL_DOWN",
    "Ball",
    "Battery",
    "BatterySocket",
    "BatteryTray",
    "Box",
    "ButtonBase",
    "ButtonCap",
    "Cube",
    "Cylinder",
    "Disc",
    "Fixed",
    "Geom",
    "Integer",
    "IntegerRange",
    "LampBody",
    "LampBulb",
    "Mesh",
    "Mug",
    "Name",
    "Parts",
    "Peg",
    "Prop",
    "Props",
    "Real",
    "RealRange",
    "Shape",
    "Sphere",
    "Steps",
    "TargetDisc",
    "Task",
    "asin",
    "atan2",
    "check",
    "cos",
    "distance",
    "exp",
    "hypot",
    "length",
    "load_file",
    "log",
    "sin",
    "split_target",
    "tan",
    "tanh",
]
