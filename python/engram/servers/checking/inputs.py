"""What answers depend on: pictures, state, words, earlier frames, and the episode before."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from engram.servers.checking.asking import Asker
from engram.servers.checking.findings import Finding
from engram.servers.checking.meaning import meant
from engram.servers.checking.recording import Recording, states_of
from engram.servers.conventions import LAYOUTS, rotation_vector

Array = npt.NDArray[Any]

_SAME = 1e-5  # distance of two answers that rounding may cause
_REPEATS = 3
_OTHER_WORDS = "do nothing"
_STEPS_BETWEEN = 6  # questions of an episode in between
_LAYOUT_STEPS = 12


def noise_of(asker: Asker, recording: Recording) -> float:
    """The largest distance of an answer to the one before, to the same first question."""
    answers = [asker.ask(recording, 0) for _ in range(_REPEATS)]
    return max(_distance(*pair) for pair in zip(answers, answers[1:]))


def _distance(a: Array, b: Array) -> float:
    length = min(len(a), len(b))
    return float(np.abs(a[:length] - b[:length]).max())


def influences(asker: Asker, recording: Recording, noise: float) -> dict[str, float]:
    """How far an answer goes when one input changes, by input; noise and less is 0."""
    step = len(recording) // 2
    before = asker.ask(recording, step)
    changes: dict[str, dict[str, Any]] = {"instruction": {"instruction": [_OTHER_WORDS]}}
    rgb = recording.rgb[step : step + 1]
    cameras = {"base image": (asker.keys.base, 0), "wrist image": (asker.keys.wrist, 3)}
    for name, (sent, channel) in cameras.items():
        if sent is not None:
            dark = rgb.copy()
            dark[..., channel : channel + 3] = 0
            changes[name] = {"rgb": dark}
    if asker.keys.state:
        changes["state"] = {"states": asker.states(recording) + 0.05}
    result = {}
    for name, change in changes.items():
        distance = _distance(before, asker.ask(recording, step, **change))
        result[name] = distance if distance > max(_SAME, 2 * noise) else 0.0
    return result


def reset_finding(asker: Asker, recording: Recording, noise: float) -> Finding | None:
    """Whether an episode before changes the answer to a first question."""
    fresh = asker.ask(recording, 0)
    for i in range(_STEPS_BETWEEN):
        asker.ask(recording, (len(recording) - 1) * (i + 1) // _STEPS_BETWEEN, first=i == 0)
    distance = _distance(fresh, asker.ask(recording, 0))
    if distance <= max(_SAME, 3 * noise):
        return None
    return Finding(
        True,
        f"the answer to an episode's first question is {distance:.3g} away from the usual one "
        "after another episode",
        "the server does not learn of a new episode, or does not forget the one before",
        "--server-reset reconnect or message",
    )


def remembers(asker: Asker, recording: Recording, noise: float) -> bool:
    """Whether an earlier frame of the episode changes an answer."""
    last = len(recording) - 1
    answers = []
    for dark in (False, True):
        rgb = recording.rgb[:1] * (0 if dark else 1)
        asker.ask(recording, 0, rgb=rgb)
        answers.append(asker.ask(recording, last, first=False))
    return _distance(*answers) > max(_SAME, 3 * noise)


# --- state ---


def _forms(chosen: str, proprio: Array) -> Mapping[str, Array]:
    """Other states of the same width, by name; an episode's, (T, W)."""
    own = states_of(chosen, proprio)
    forms = {}
    if proprio.shape[1] == 7:
        for layout in LAYOUTS:
            if layout not in (chosen, "joints8"):
                states = states_of(layout, proprio)
                if states.shape == own.shape:
                    forms[layout] = states
        backwards = own.copy()
        backwards[:, 3:6] = own[:, 5:2:-1]
        forms["angles in the order yaw, pitch, roll"] = backwards
        if chosen == "libero8":
            short = own.copy()
            short[:, 3:6] = rotation_vector(proprio[:, 3:6])
            forms["rotation vectors of at most pi, which flip their sign there"] = short
    degrees = own.copy()
    degrees[:, slice(3, 6) if proprio.shape[1] == 7 else slice(0, 7)] *= 180 / np.pi
    forms["angles in degrees"] = degrees
    return forms


def jumps_of(layout: str, proprio: Array) -> int:
    """Steps in which a number of the state jumps by more than pi."""
    steps = np.abs(np.diff(states_of(layout, proprio), axis=0))
    return int((steps.max(1) > np.pi).sum())


def state_findings(asker: Asker, recording: Recording) -> list[Finding]:
    """Whether answers to other forms of the state are nearer to the oracle's."""
    layout = asker.keys.layout
    steps = np.linspace(0, len(recording) - 1, _LAYOUT_STEPS).round().astype(int)
    oracle = recording.actions[steps]

    def error(states: Array) -> float:
        answers = np.stack([asker.ask(recording, int(t), states=states)[0] for t in steps])
        distance = np.abs(np.clip(meant(asker.convention, answers), -4, 4) - oracle)
        return float(distance.mean())

    own = error(asker.states(recording))
    errors = {name: error(states) for name, states in _forms(layout, recording.proprio).items()}
    best = min(errors, key=lambda name: errors[name])
    if own < 0.02 or errors[best] > 0.7 * own:
        return []
    remedy = f"--server-state {best}" if best in LAYOUTS else "the server's own conversion"
    return [
        Finding(
            True,
            f"the distance to the oracle's actions falls from {own:.3f} to {errors[best]:.3f} with "
            f"the state as {best}, instead of {layout}",
            "the policy was trained on that form of the state",
            remedy,
        )
    ]


def jump_finding(asker: Asker, recording: Recording) -> Finding | None:
    """A layout that jumps at half a turn."""
    layout = asker.keys.layout
    jumps = jumps_of(layout, recording.proprio) if asker.keys.state else 0
    if not jumps:
        return None
    return Finding(
        False,
        f"states of {layout} jump by a whole turn in {jumps} of {len(recording) - 1} steps",
        "right for a policy that was trained on the benchmark's own angles; data sets of LeRobot "
        "have continuous ones",
        "--server-state tcp7_continuous",
    )
