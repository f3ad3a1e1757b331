"""What each number of an action does here, by small motions from the rest pose."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from engram.datasets.spaces import CONTROL_MODE, Spaces
from engram.factory import make
from engram.servers.conventions import ACTIONS, to_engram

Array = npt.NDArray[Any]

_TASK = "InterceptSlow-VLA-v0"  # in which no action is replaced
_STEPS = 3
_METRES, _RADIANS = 0.05, 0.05  # that a small motion asks for
_NAMES = ("x", "y", "z", "roll", "pitch", "yaw", "opening")


def small_motions(convention: str) -> list[str]:
    """A line for each of the seven numbers of a TCP action: what is sent, and what moves."""
    meaning = ACTIONS[convention]
    metres, radians = (0.1, 0.1) if meaning is None else (meaning.metres, meaning.radians)
    closed, opened = (-1.0, 1.0) if meaning is None else (meaning.closed, meaning.open)
    env: Any = make(_TASK, pins={"robot_noise": [0.0] * 7})
    rest = np.append(np.zeros(6), opened)
    lines = []
    for i, name in enumerate(Spaces(CONTROL_MODE).action_names):
        action = rest.copy()
        action[i] = closed if i == 6 else _METRES / metres if i < 3 else _RADIANS / radians
        moved = _moved(env, to_engram(convention, action[None])[0])
        lines.append(f"{i} {name}: {action[i]:+.3g} moves {_words(moved)}")
    env.close()
    return lines


def _moved(env: Any, action: Array) -> Array:
    _, info = env.reset(seed=0)
    start = np.array(info["proprio"], np.float64)
    for _ in range(_STEPS):
        _, _, _, _, info = env.step(action.astype(np.float32))
    moved = np.array(info["proprio"], np.float64) - start
    moved[3:6] = (moved[3:6] + np.pi) % (2 * np.pi) - np.pi
    return moved


def _words(moved: Array) -> str:
    """What moved most; 1 mm counts as much as 0.001 rad."""
    i = int(np.abs(moved).argmax())
    if 3 <= i < 6:
        return f"{_NAMES[i]} by {moved[i]:+.3f} rad"
    return f"{_NAMES[i]} by {1000 * moved[i]:+.0f} mm"
