"""Draws can be pinned, matter, and leave the oracle time."""

from __future__ import annotations

from typing import Any

import numpy as np

from engram.errors import InvalidArgumentError
from engram.kit.checks.intervals import interval
from engram.kit.checks.play import actions_of, difference, play
from engram.kit.checks.scripts import successes
from engram.kit.checks.subject import Subject

_SEEDS = (70, 71, 72)
_ROBOT = "robot_noise"


def check(subject: Subject) -> None:
    found = len(subject.findings)
    values = {name: pinned for name, pinned in _values_by_draw(subject).items() if pinned}
    for name, pinned in values.items():
        if not _check_pins(subject, name, pinned):
            return
    if subject.is_own:
        for name, pinned in values.items():
            _check_use(subject, name, pinned)
        _check_ranges(subject)
    _check_long_phases(subject)
    if len(subject.findings) == found:
        subject.add("draws", "ok", f"pins of {', '.join(values) or 'no draw'} are followed")


def _values_by_draw(subject: Subject) -> dict[str, list[Any]]:
    """Least, greatest and random values of every draw."""
    drawn: list[dict[str, Any]] = []
    with subject.batch(4) as env:
        env.reset(seed=[800, 801, 802, 803])
        every = env.drawn()
        drawn = [{name: value[i] for name, value in every.items()} for i in range(4)]
    found = {}
    for draw in subject.description["draws"]:
        name, kind = draw["name"], subject.declared.get(draw["name"], {}).get("kind", "")
        if name == _ROBOT:
            continue
        ends: list[Any] = []
        if kind in ("integer", "real") or (not kind and draw["width"] == 1):
            width = draw["width"]
            ends = [np.full(width, draw["low"]), np.full(width, draw["high"])]
        found[name] = ends + [np.ravel(one[name]) for one in drawn if name in one]
    return found


def _check_pins(subject: Subject, name: str, pinned: list[Any]) -> bool:
    for value in pinned:
        with subject.batch(2) as env:
            try:
                env.reset(seed=3, options={"pins": {name: value.tolist()}})
            except InvalidArgumentError as error:
                subject.add("draws", "wrong", f"draw {name!r}: {value.tolist()}, a value that is "
                            f"drawn, is refused as a pin: {error}")  # fmt: skip
                return False
            got = env.drawn().get(name)
            expected = value.astype(got.dtype) if got is not None else None
            if got is not None and not (got.reshape(2, -1) == expected).all():
                subject.add("draws", "wrong", f"draw {name!r}: pinned to {value.tolist()}, but "
                            f"drawn as {got[0]}")  # fmt: skip
                return False
    return True


def _check_use(subject: Subject, name: str, pinned: list[Any]) -> None:
    """Whether anything depends on a draw."""
    distinct = [one for one in pinned if (one != pinned[0]).any()]
    if not distinct:
        return
    policy, images = subject.policy, sorted({1, subject.horizon // 2, subject.horizon})
    first = play(subject, _SEEDS, policy=policy, pins={name: pinned[0].tolist()}, images=images)
    for value in (distinct[0], distinct[-1]):
        other = play(
            subject, _SEEDS, policy=policy, pins={name: value.tolist()}, images=images,
            actions=actions_of(first, policy),
        )  # fmt: skip
        if difference(first, other) is not None:
            return
    subject.add("draws", "note", f"draw {name!r} changes nothing: neither images, state, infos "
                "and rewards nor what scripts do; is it used?")  # fmt: skip


def _check_ranges(subject: Subject) -> None:
    """Ranges can be narrowed at a reset."""
    for name, draw in subject.declared.items():
        constant = draw.get("constant")
        if constant is None:
            continue
        for end in (draw["low"], draw["high"]):
            with subject.batch(4) as env:
                env.reset(seed=3, options={"constants": {constant: (end, end)}})
                got = env.drawn()[name]
                if not (got == np.asarray(end, got.dtype)).all():
                    subject.add("draws", "wrong", f"draw {name!r}: {constant} narrowed to {end} at "
                                f"a reset, but drawn as {got}")  # fmt: skip


def _check_long_phases(subject: Subject) -> None:
    """The longest phases leave the oracle time."""
    long = {draw["name"]: draw["high"] for draw in subject.description["draws"]
            if draw["integer"] and draw["width"] == 1
            and draw["unit"] == "control steps"}  # fmt: skip
    if not long or "oracle" not in subject.scripts:
        return
    count = min(subject.episodes, 64)
    number = successes(subject, "oracle", episodes=count, pins=long)[0]
    if interval(number, count)[1] >= subject.floor:
        return
    words = ", ".join(f"{name} {value:g}" for name, value in long.items())
    subject.add(
        "draws", "wrong",
        f"with the longest phases ({words}) oracle() succeeds in {number} of {count} episodes: "
        f"the horizon, {subject.horizon}, is too short; a longer one, shorter phases, or a greater "
        "time_to_act (which refuses such constants) needed", oracle=number, episodes=count,
    )  # fmt: skip
