"""Docstrings of the classes of tasks: what happens, what success is, what can be changed."""

from __future__ import annotations

import textwrap

from engram.mikasa import _families
from engram.typing import TaskSummary

_CUE = "cue_steps_per_env"
_DELAY = "empty_steps_per_env"
_REMEMBERED = (
    f"The target is shown alone for {_CUE} steps, the table is empty for {_DELAY} steps, then all "
    "candidates stand in places of their own."
)
_TOUCHED = "The TCP is within GOAL_THRESH of the target, and the robot is static."
_SHOWN = f"Balls are shown for {_CUE} steps, then mugs stand over their places."
_CAPACITY_SUCCESS = (
    "All cubes of the cue and no other have been touched{order}, then the button was pressed and "
    "released, the robot is static, and no cube was shoved by more than "
    "MAX_ALLOWED_CUBE_DISPLACEMENT."
)
_CAPACITY_FLOW = (
    "The cue shows cubes {how}, the table is empty, then nine cubes and a button stand."
)
_BATTERIES = (
    "A tray holds ACTIVE_BATTERY_COUNT batteries that look alike. One after another is put into "
    "the socket, the button is pressed, and the lamp tells whether it works."
)

# What happens, and what success is.
_FAMILIES: dict[str, tuple[str, str]] = {
    **dict.fromkeys(("RememberColor", "RememberShape", "RememberShapeAndColor"),
                    (_REMEMBERED, _TOUCHED)),
    **dict.fromkeys(("FindImposterColor", "FindImposterShape", "FindImposterShapeAndColor"), (
        f"All objects but one are shown for {_CUE} steps, the table is empty for {_DELAY} steps, "
        "then all of them stand in other places, with one that was not shown.",
        "The TCP is within GOAL_THRESH of the new one; with the original's rules the robot is "
        "static, too.",
    )),
    "ShellGameTouch": (
        _SHOWN + " The ball's mug has to be touched.",
        _TOUCHED + " No mug was shoved by more than MUG_DISPLACEMENT_SUCCESS_THRESH.",
    ),
    "ShellGamePush": (
        _SHOWN + " The ball's mug has to be pushed forward.",
        "The mug is within 1.6 GOAL_THRESH of the goal (with engram's rules its ball is within "
        "GOAL_THRESH), and the arm is nearly still.",
    ),
    "ShellGamePick": (
        _SHOWN + " The ball's mug has to be lifted.",
        "The mug is within 1.6 GOAL_THRESH of the goal above (with engram's rules its ball is "
        "within GOAL_THRESH), and the robot is static.",
    ),
    "ShellGameColorLampTouch": (
        f"Three balls in different colours are shown for {_CUE} steps, then mugs stand over them "
        "and a lamp shows one of the colours.",
        _TOUCHED,
    ),
    "ShellGameShuffleTouch": (
        f"A ball is shown for {_CUE} steps without mugs. Mugs appear with the first of NUM_SWAPS "
        "swaps, in which two of them change places.",
        _TOUCHED,
    ),
    "ShellGameShuffleColorLampTouch": (
        f"Three balls are shown for {_CUE} steps. Mugs appear with the first of NUM_SWAPS swaps; "
        "then a lamp shows the colour of one ball.",
        _TOUCHED,
    ),
    "Intercept": (
        "A ball rolls across the table.",
        "The ball's centre is within GOAL_RADIUS of the target's.",
    ),
    "InterceptGrab": (
        "A ball rolls across the table.",
        "Both fingers press the ball, and the robot is static.",
    ),
    "RotateLenient": (
        "A peg lies on the table; the instruction names an angle in degrees, task_cue in rad.",
        "The peg has turned by the angle, within angle_threshold, and the robot is static.",
    ),
    "RotateStrict": (
        "A peg lies on the table; the instruction names an angle in degrees, task_cue in rad.",
        "The peg has turned by the angle, within angle_threshold, its centre is within 5 cm of "
        "where it was, and the robot is static.",
    ),
    "TakeItBack": (
        "A cube has to be brought to the red target, which then turns violet and disappears from "
        "the task, and back to where it came from.",
        "The cube has been within GOAL_RADIUS of the target, and is within GOAL_RADIUS of its "
        "first place.",
    ),
    "TraceShape": (
        "A red cube traces a contour, which the robot has to repeat with a green one.",
        "The green cube has passed all checkpoints of the contour and is back at the first.",
    ),
    "TraceShapeSeq": (
        "A red cube traces several contours, which the robot has to repeat with a green one, in "
        "order; then it presses the button.",
        "The button is pressed after all contours were closed; before that it is a failure.",
    ),
    "BunchOfColors": (
        _CAPACITY_FLOW.format(how="all at once"), _CAPACITY_SUCCESS.format(order="")
    ),
    "SeqOfColors": (
        _CAPACITY_FLOW.format(how="one after another"),
        _CAPACITY_SUCCESS.format(order=" (in the cue's order with the original's rules)"),
    ),
    "ChainOfColors": (
        _CAPACITY_FLOW.format(how="one after another"),
        _CAPACITY_SUCCESS.format(order=" in the cue's order"),
    ),
    "BlinkCountButtonPress": (
        "A lamp blinks target_blinks times; then the left button is pressed as often, and the "
        "right one submits.",
        "The submission comes with press_count = target_blinks; more presses or another count are "
        "a failure.",
    ),
    "TimedTransfer": (
        "A lamp signals once. The cube has to be on the red disc DELAY_STEPS later, within a "
        "tolerance.",
        "The cube is on the red disc in the window, and was not there before it.",
    ),
    "GatherAndRecall": (
        "N_CUBES cubes have to be gathered on the disc; the lamp flashes in a colour meanwhile, "
        "whose button has to be pressed in the end.",
        "The first button that is pressed while all cubes are on the disc is the flash's colour.",
    ),
    "BatteriesCheckerEasy": (
        _BATTERIES, "All WORKING_BATTERY_COUNT working batteries have been found."
    ),
    "BatteriesCheckerHard": (
        _BATTERIES + " Batteries go back to any slot, so places have to be remembered.",
        "All WORKING_BATTERY_COUNT working batteries have been found; with the original's rules "
        "every battery has been tested, and none is lost.",
    ),
}  # fmt: skip


def of_class(task: TaskSummary, title: str, constants: tuple[str, ...]) -> str:
    """The docstring of a class of this task."""
    flow, success = _FAMILIES[task["family"]]
    if task["split"] == "rl":
        flow = flow.replace(f"for {_CUE} steps", "first").replace(
            f"for {_DELAY} steps", "for a while"
        )
        if task["family"] in _families.CAPACITY:
            flow = flow.replace(" and a button stand", " stand")
            success = (
                "All cubes of the cue and no other have been touched, and the robot is static."
            )
    ends = "" if task["split"] != "rl" else " Success ends the episode."
    changed = ", ".join(constants) or "those that dir() lists"
    paragraphs = (
        ("Flow", flow),
        ("Success", success + ends),
        ("Customisation", f"class constants, here or in a subclass: {changed}; "
                          "``engram.describe(id)['changeable']`` has bounds and units."),
    )  # fmt: skip
    return "\n".join([title, "", *(_indented(name, text) for name, text in paragraphs)])


def _indented(name: str, text: str) -> str:
    return textwrap.fill(f"{name}: {text}", 96, subsequent_indent="    ")
