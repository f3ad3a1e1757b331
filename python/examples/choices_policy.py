#!/usr/bin/env python3
r"""Choosers for `engram eval --policy-choices`: policies that name an answer instead of acting.

    engram eval RememberColor9-VLA-v0 --obs objects \
      --policy-choices "python3 python/examples/choices_policy.py"
    engram eval RememberColor9-VLA-v0 --obs objects \
      --policy-choices "python3 python/examples/choices_policy.py --guess"

The first one reads the objects in words and remembers them by plain rules; the second one guesses.
Replace `answer` with a language model: `prompt` has all that one needs. Standard output belongs to
the protocol (docs/choices.md): print to standard error only.
"""

import math
import random
import re
import struct
import sys

from pipe_policy import HELLO, OBJECTS, RGB, TASK, Reader, greet, read, read_task, send

QUESTION, CHOICE = 6, 7
STEPS_PER_SHAPE = 64  # NUM_WAYPOINTS of the TraceShape tasks
PLACE = re.compile(r"(.*) at x (\S+) m, y (\S+) m, z (\S+) m(.*)")


def prompt(asked):
    """The question as a text for a language model."""
    lines = [asked["instruction"], "x grows away from the robot, y to the right in images."]
    lines += [f"step {step}: {text}" for step, text in zip(asked["steps"], asked["text"])]
    return "\n".join([*lines, asked["question"], *asked["choices"]])


def guess(asked):
    """Uniform over the lengths of an answer, then over its items."""
    numbers = random.Random(f"{asked['policy_seed']} {asked['episode']} {asked['index']}")
    length = numbers.randint(asked["least"], asked["most"])
    if asked["repeats"]:
        return numbers.choices(asked["choices"], k=length)
    return numbers.sample(asked["choices"], length)


# --- rules ---


def things(text):
    """What is seen, but for the hand: (name, x, y, further words)."""
    found = [PLACE.fullmatch(part) for part in text.split("; ")[1:]]
    return [(m[1], float(m[2]), float(m[3]), m[5]) for m in found if m]


def names(choice, name):
    """True if a choice such as "the cross" means a thing that is seen as a "blue cross"."""
    return f" {name}".endswith(choice.removeprefix("the"))


def appearance(asked, frames):
    """Choices in the order in which they have been seen."""
    order = []
    for frame in frames:
        for name, *_ in frame:
            order += [c for c in asked["choices"] if names(c, name) and c not in order]
    return order


def lit(frame, color=""):
    return [name for name, _, _, more in frame if "lit" in more and name.startswith(color)]


def place_of_ball(frames, color):
    """Follows the cup over the ball, from place to place."""
    at = None
    for frame in frames:
        ball = [(x, y) for name, x, y, _ in frame if name == f"{color} ball"]
        cups = [(x, y) for name, x, y, _ in frame if name.endswith("cup")]
        if ball:
            at = ball[0]
        elif cups and at:
            at = min(cups, key=lambda cup: math.dist(cup, at))
    row = sorted({y for name, _, y, _ in frames[-1] if name.endswith("cup")})
    middle = (row[0] + row[-1]) / 2
    offset = 3 * (at[1] - middle) / (row[-1] - row[0])
    return "left" if offset < -0.5 else "right" if offset > 0.5 else "middle"


def traced_shapes(frames, steps):
    """While the lamp is red, the red cube takes as many steps for every shape."""
    demo = [(step, frame) for step, frame in zip(steps, frames) if lit(frame, "red")]
    shapes = {}
    for step, frame in demo:
        shapes.setdefault((step - demo[0][0]) // STEPS_PER_SHAPE, []).append(frame)
    return [f"a {traced_shape(shape)}" for shape in shapes.values()]


def traced_shape(frames):
    """By how much nearer the sides of a shape are to its centre than its corners."""
    path = {(x, y) for frame in frames for name, x, y, _ in frame if name == "red cube"}
    center = [sum(point[i] for point in path) / len(path) for i in (0, 1)]
    radii = sorted(math.dist(point, center) for point in path)
    ratio = radii[len(radii) // 10] / radii[-1 - len(radii) // 10]
    return "circle" if ratio > 0.84 else "square" if ratio > 0.65 else "triangle"


def answer(asked, notes):
    """`notes`: what the chooser itself remembers of the episode."""
    if asked["text"] is None:
        sys.exit("choices_policy: --obs objects needed, or --guess")
    frames = [things(text) for text in asked["text"]]
    question, choices = asked["question"], asked["choices"]
    if "cup" in question:
        lamp = lit(frames[-1])
        place = place_of_ball(frames, lamp[0].split()[0] if lamp else "red")
        return [f"the {place} cup"]
    if "battery" in question:  # the next one that has not been tested
        notes.append(next(c for c in sorted(choices) if c not in notes))
        return notes[-1:]
    if "object" in question:
        shown = appearance(asked, frames[:1])
        new = [c for c in choices if c not in shown]
        return new if len(new) == 1 else shown
    if "cubes" in question:
        return appearance(asked, frames[:-1])[: asked["most"]]
    if "blinked" in question:
        states = [bool(lit(frame, "blue")) for frame in frames]
        count = sum(now and not before for before, now in zip([False, *states], states))
        return [c for c in choices if c.split()[0] == str(count)]
    if "button" in question:
        flash = next(lamp for frame in frames for lamp in lit(frame))
        return [f"the {flash.split()[0]} button"]
    if "traced" in question:
        return traced_shapes(frames, asked["steps"])
    if "first" in question:
        y = next(y for name, _, y, _ in frames[0] if name.endswith("cube"))
        return [min(choices, key=lambda c: abs(float(c.split()[-2]) - y))]
    return guess(asked)


# --- the protocol ---


def read_question(message, hello, state_dim, policy_seed):
    asked = {"policy_seed": policy_seed, "text": None, "rgb": None, "state": None}
    for name in ("slot", "episode", "step", "index"):
        asked[name] = message.array("i", 1)[0]
    asked["instruction"], asked["question"] = message.text(), message.text()
    for name in ("least", "most", "repeats"):
        asked[name] = message.number()
    asked["choices"] = [message.text() for _ in range(message.number())]
    frames = message.number()
    asked["steps"] = message.array("i", frames)
    asked["proprio"] = message.array("f", frames, hello["proprio"])
    if hello["observes"] == RGB:
        image = (hello["height"], hello["width"], hello["channels"])
        asked["rgb"] = message.array("B", frames, *image)
    else:
        asked["state"] = message.array("f", frames, state_dim)
    if hello["observes"] == OBJECTS:
        asked["text"] = [message.text() for _ in range(frames)]
    return asked


def main():
    hello, state_dim, policy_seed, notes = None, 0, 0, {}
    guesses = "--guess" in sys.argv[1:]
    while True:
        kind, size = struct.unpack("<II", read(8))
        message = Reader(read(size))
        if kind == HELLO:
            hello = greet(message)
        elif kind == TASK:
            _, state_dim, policy_seed = read_task(message)
        elif kind == QUESTION:
            asked = read_question(message, hello, state_dim, policy_seed)
            if asked["index"] == 0:
                notes[asked["slot"]] = []
            named = guess(asked) if guesses else answer(asked, notes[asked["slot"]])
            body = struct.pack("<I", len(named))
            for text in named:
                body += struct.pack("<I", len(text.encode())) + text.encode()
            send(CHOICE, body)


if __name__ == "__main__":
    main()
