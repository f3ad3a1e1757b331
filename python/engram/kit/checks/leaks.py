"""Nothing shows what is hidden once the cue is over."""

from __future__ import annotations

from typing import Any

import numpy as np

from engram.kit.checks.play import Player, causes_first, different_rows
from engram.kit.checks.subject import Subject

_SEED, _COUNT = 300, 3
_CAMERAS = ("base_camera", "hand_camera")
# Columns of props by what is wrong if they differ.
_COLUMNS = (
    ("prop_status", "is shown in one and not in the other (place, hide)"),
    ("prop_pos", "is at another place (place, move)"),
    ("prop_quat", "is turned otherwise (place)"),
    ("prop_rgba", "has another colour (paint)"),
    ("prop_emission", "emits other light (paint: emission)"),
)


def check(subject: Subject) -> None:
    name = subject.hidden
    if not name:
        more = "" if subject.description["candidates"] == 1 else \
            ", although there are candidates"  # fmt: skip
        subject.add("leaks", "note", f"hidden names no draw{more}: no search for leaks")
        return
    found = len(subject.findings)
    values = _hidden_values(subject, name)
    for other in values[1:]:
        for options in ({"obs_mode": "rgb"}, {"obs_mode": "objects"},
                        {"obs_mode": "objects", "reward_mode": "sparse"}):  # fmt: skip
            _compare(subject, name, [values[0], other], options)
            if len(subject.findings) > found:
                return
    subject.add(
        "leaks", "ok",
        f"episodes that differ in draw {name!r} alone have the same images, objects, proprio, "
        "infos and sparse rewards once the cue is over",
    )  # fmt: skip


def _hidden_values(subject: Subject, name: str) -> list[list[float]]:
    """Up to three values that differ."""
    draw = next(one for one in subject.description["draws"] if one["name"] == name)
    kind = subject.declared.get(name, {}).get("kind", "")
    candidates = []
    if kind in ("integer", "real") or (not kind and draw["width"] == 1):
        candidates = [np.full(draw["width"], draw["low"]), np.full(draw["width"], draw["high"])]
    with subject.batch(4) as env:
        env.reset(seed=[900, 901, 902, 903])
        drawn = env.drawn()
        if name in drawn:
            candidates += [np.ravel(one) for one in drawn[name]]
    found: list[list[float]] = []
    for one in candidates:
        if one.tolist() not in found:
            found.append(one.tolist())
    return found[:3]


def _compare(subject: Subject, name: str, pair: list[Any], options: dict[str, Any]) -> None:
    """Plays both episodes with zero actions, from some seeds at once."""
    seeds = list(range(_SEED, _SEED + _COUNT))
    with subject.batch(_COUNT, **options) as one, subject.batch(_COUNT, **options) as other:
        players = [Player(subject, env, None) for env in (one, other)]
        for player, value in zip(players, pair):
            player.begin(seeds, {name: value})
        drawn = one.drawn()
        end, last = subject.cue_end(drawn, _COUNT), subject.start_of_last_phase(drawn, _COUNT)
        if end is None:
            subject.add("leaks", "note", "when the cue ends is not known: no search for leaks")
            return
        if options.get("reward_mode") == "sparse":
            last = np.full(_COUNT, subject.horizon + 1)
        zero = np.zeros(one.action_space.shape, np.float32)
        answered = np.zeros(_COUNT, bool)
        for step in range(subject.horizon + 1):
            for player in players if step else []:
                player.step(zero)
            first, second = (player.steps[-1] for player in players)
            answered |= first.get("info answered", answered).astype(bool)
            after = (step >= end) & ~answered
            dense = np.zeros(_COUNT, bool) if last is None else after & (step < last)
            found = _telling(subject, first, second, after, dense)
            if found is not None:
                _report(subject, name, pair, found, step, int(end[found[1]]), (first, second))
                return


def _telling(
    subject: Subject, first: dict[str, Any], second: dict[str, Any], after: Any, dense: Any
) -> tuple[str, int] | None:
    """The first output that may not differ but does, and the environment.

    dense: environments in which the reward may not differ.
    """
    closed = {one["name"] for one in subject.description["outputs"] if one["privileged"]}
    for output in sorted(first, key=causes_first):
        if output.removeprefix("info ") in closed | {"episode_return"}:
            continue
        unlike = different_rows(first[output], second[output])
        unlike &= dense if output == "reward" else after
        if unlike.any():
            return output, int(unlike.argmax())
    return None


def _report(
    subject: Subject,
    name: str,
    pair: list[Any],
    found: tuple[str, int],
    step: int,
    end: int,
    outputs: tuple[dict[str, Any], dict[str, Any]],
) -> None:
    output, row = found
    what, advice = output, "; look at place(), hide() and paint() after the cue"
    if output == "rgb":
        unlike = (outputs[0]["rgb"][row] != outputs[1]["rgb"][row]).any(axis=(0, 1))
        cameras = [camera for i, camera in enumerate(_CAMERAS) if unlike[3 * i : 3 * i + 3].any()]
        what = "image of " + " and ".join(cameras)
    elif output == "reward":
        advice = "; before the last phase reward() may not depend on it"
    elif output.startswith("info "):
        advice = "; add_info(..., privileged=True) keeps it from policies"
    if end == 0:
        advice += "; reset() writes cue_end, or a phase of the name cue does"
    values = " and ".join(_short(value) for value in pair)
    subject.add(
        "leaks", "wrong",
        f"{what} in step {step} tells draw {name!r} (values {values}; seed {_SEED + row}; the cue "
        f"ends at step {end}){_explained(subject, row)}{advice}", step=step, output=output,
    )  # fmt: skip


def _short(value: Any) -> str:
    return f"{value[0]:g}" if len(value) == 1 else str([float(f"{one:g}") for one in value[:6]])


def _explained(subject: Subject, row: int) -> str:
    """Which prop differs between both episodes, and how."""
    if not subject.is_own:
        return ""
    for column, words in _COLUMNS:
        one, other = (task.__dict__["_whole"][column][row] for task in subject.tasks[-2:])
        unlike = (one != other).reshape(len(one), -1).any(axis=1)
        for i, prop in enumerate(subject.prop_names):
            if unlike[i]:
                return f": prop {prop!r} {words}"
    return ""
