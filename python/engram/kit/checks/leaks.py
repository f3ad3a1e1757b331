"""Nothing shows what is hidden once the cue is over."""

from __future__ import annotations

from typing import Any

import numpy as np

from engram.kit.checks.play import Player, different_rows
from engram.kit.checks.subject import Subject

_SEED = 300
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
        word = "hidden names no draw" if subject.is_own else "which draw is hidden is not known here"
        subject.add("leaks", "note", f"{word}{more}: no search for leaks")
        return
    found = len(subject.findings)
    values = _hidden_values(subject, name)
    for other in values[1:]:
        for options in ({"obs_mode": "rgb"}, {"obs_mode": "objects"},
                        {"obs_mode": "objects", "reward_mode": "sparse"}):  # fmt: skip
            _compare(subject, name, [values[0], other], options)
            if len(subject.findings) > found:
                return
    subject.add("leaks", "ok", f"episodes that differ in draw {name!r} only have the same pictures, "
                "objects, proprio, infos and sparse rewards once the cue is over")  # fmt: skip


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
    """Plays both episodes with zero actions, from three seeds at once."""
    count = 3
    seeds = list(range(_SEED, _SEED + count))
    outputs_privileged = {one["name"] for one in subject.description["outputs"] if one["privileged"]}
    pictures = options["obs_mode"] == "rgb"
    with subject.batch(count, **options) as one, subject.batch(count, **options) as other:
        tasks = subject.tasks[-2:]
        players = [Player(subject, env, None) for env in (one, other)]
        for player, value in zip(players, pair):
            player.begin(seeds, {name: value})
        subject_ends = subject.cue_end(one.drawn(), count)
        if subject_ends is None:
            subject.add("leaks", "note", "when the cue ends is not known: no search for leaks")
            return
        last = subject.start_of_last_phase(one.drawn(), count)
        zero = np.zeros(one.action_space.shape, np.float32)
        answered = np.zeros(count, bool)
        for step in range(subject.horizon + 1):
            if step > 0:
                for player in players:
                    player.step(zero)
            first, second = (player.steps[-1] for player in players)
            answered |= first.get("info answered", answered).astype(bool)
            after = (step >= subject_ends) & ~answered
            for output, value in first.items():
                if output.removeprefix("info ") in outputs_privileged | {"episode_return"}:
                    continue
                rows = after
                if output == "reward" and options.get("reward_mode") != "sparse":
                    rows = after & (step < last) if last is not None else after & False
                unlike = different_rows(value, second[output]) & rows
                if unlike.any():
                    row = int(unlike.argmax())
                    _report(subject, name, pair, output, step, int(subject_ends[row]),
                            _explained(subject, tasks, row), first, second, row)  # fmt: skip
                    return
            if not pictures and step > 40 and step > subject_ends.max() + 60:
                continue


def _report(
    subject: Subject, name: str, pair: list[Any], output: str, step: int, end: int, props: str,
    first: dict[str, Any], second: dict[str, Any], row: int,
) -> None:  # fmt: skip
    what = output
    if output == "rgb":
        unlike = (first["rgb"][row] != second["rgb"][row]).any(axis=(0, 1))
        cameras = [camera for i, camera in enumerate(_CAMERAS) if unlike[3 * i : 3 * i + 3].any()]
        what = "picture of " + " and ".join(cameras)
    elif output == "reward":
        what = "reward"
    values = " and ".join(f"{_short(value)}" for value in pair)
    advice = {
        "reward": "; before the last phase reward() may not depend on it",
        "objects": "; look at place(), hide() and paint() after the cue",
    }.get(output, "")
    if output.startswith("info "):
        advice = "; add_info(..., privileged=True) keeps it from policies"
    elif output == "rgb":
        advice = "; look at place(), hide() and paint() after the cue"
    subject.add(
        "leaks", "wrong",
        f"{what} in step {step} tells draw {name!r} (values {values}; seed {_SEED + row}; the cue "
        f"ends at step {end}){props}{advice}", step=step, output=output,
    )  # fmt: skip


def _short(value: Any) -> str:
    return f"{value[0]:g}" if len(value) == 1 else str([float(f"{one:g}") for one in value[:6]])


def _explained(subject: Subject, tasks: list[Any], row: int) -> str:
    """Which props differ between both episodes, and how."""
    if not subject.is_own:
        return ""
    views = [task.__dict__["_whole"] for task in tasks]
    for column, words in _COLUMNS:
        one, other = (np.array(view[column][row]) for view in views)
        unlike = (one != other).reshape(len(one), -1).any(axis=1)
        for i, prop in enumerate(subject.prop_names):
            if unlike[i]:
                return f": prop {prop!r} {words}"
    return ""
