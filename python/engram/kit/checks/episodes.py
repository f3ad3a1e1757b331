"""An episode is the same in every batch, slot, thread and process."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from typing import Any

import numpy as np

from engram.kit.checks.hints import suspicious_lines
from engram.kit.checks.play import (
    Player,
    actions_of,
    causes_first,
    difference,
    different_rows,
    play,
    rows_of,
)
from engram.kit.checks.subject import Subject

_SEEDS = tuple(range(40, 56))
_FRESH_SECONDS = 300
_PROGRAM = (  # imports nothing from the current folder
    "import sys; sys.path[:] = [path for path in sys.path if path]; "
    "from engram.kit.checks.__main__ import run; run()"
)


def check(subject: Subject) -> None:
    policy = subject.policy
    images = sorted({1, subject.horizon // 2, subject.horizon})
    whole = play(subject, _SEEDS, policy=policy, images=images, threads=1)
    actions = actions_of(whole, policy)

    again = play(subject, _SEEDS, policy=policy, images=images, threads=1)
    found = difference(whole, again)
    if found is not None:
        subject.add(
            "episodes", "wrong",
            f"{_what(found, _SEEDS)} in the second of two runs in one process: only draws may be "
            "random, and what methods keep has to be in columns (remember()), not in globals or "
            f"objects{_lines(subject)}", step=found[1],
        )  # fmt: skip
        return
    elsewhere = _in_other_batches(subject, whole, actions)
    if elsewhere is not None:
        how, what = elsewhere
        subject.add(
            "episodes", "wrong",
            f"{what} {how}: a method mixes environments (a mean, maximum or index over all rows), "
            f"or keeps state outside of columns{_lines(subject)}",
        )  # fmt: skip
        return
    sentence = _in_a_fresh_process(subject)
    if sentence:
        subject.add("episodes", "wrong", sentence)
        return
    subject.add(
        "episodes", "ok",
        f"{len(_SEEDS)} episodes are the same, bit for bit, in batches of 1, 5 and 16, in other "
        "slots, with more threads, after partial resets"
        + (", and in a fresh process" if subject.file or not subject.is_own else ""),
        episodes=len(_SEEDS),
    )  # fmt: skip


def _what(found: tuple[str, int, int], seeds: Any) -> str:
    name, step, env = found
    return f"{name} in step {step} of seed {seeds[env]} differs"


def _lines(subject: Subject) -> str:
    return suspicious_lines(subject.tasks[-1]) if subject.is_own else ""


def _in_other_batches(
    subject: Subject, whole: list[dict[str, Any]], actions: list[Any]
) -> tuple[str, str] | None:
    """Where and what differs in batches of other sizes; None: nothing."""
    policy = subject.policy
    layouts: tuple[tuple[list[int], str, dict[str, Any]], ...] = (
        ([3], "in a batch of 1", {"threads": 1}),
        ([9], "in a batch of 1", {"threads": 1}),
        ([11, 2, 7, 0, 14], "in a batch of 5, in other slots", {"threads": 2, "chunk": 1}),
        (list(range(15, -1, -1)), "in other slots of the batch", {"threads": 2, "lanes": 1}),
    )
    for rows, how, options in layouts:
        seeds = [_SEEDS[row] for row in rows]
        chosen = [step[rows] for step in actions]
        part = play(subject, seeds, policy=policy, actions=chosen, **options)
        found = difference(rows_of(_without_images(whole), rows), part)
        if found is not None:
            return how, _what(found, seeds)
    return _after_partial_resets(subject, whole, actions)


def _without_images(steps: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [{name: value for name, value in one.items() if name != "image"} for one in steps]


def _after_partial_resets(
    subject: Subject, whole: list[dict[str, Any]], actions: list[Any]
) -> tuple[str, str] | None:
    """Some environments begin three steps later than others, in the middle of their episodes."""
    late, count = min(3, subject.horizon - 1), len(_SEEDS)
    mask = np.arange(count) % 2 == 0
    with subject.batch(count, threads=2) as env:
        player = Player(subject, env, subject.policy)
        player.begin(np.where(mask, 7000, _SEEDS).tolist())
        for step in range(1, subject.horizon + 1):
            if step == late + 1:
                env.reset(seed=list(_SEEDS), options={"reset_mask": mask})
            own = step - np.where(mask & (step > late), late, 0)
            given = np.array([actions[own[i] - 1][i] for i in range(count)])
            outputs = player.step(given)
            valid = ~mask | (step > late)
            for name in sorted(outputs, key=causes_first):
                value = outputs[name]
                expected = np.array([whole[own[i]][name][i] for i in range(count)])
                unlike = different_rows(value, expected) & valid
                if unlike.any():
                    found = name, int(own[unlike.argmax()]), int(unlike.argmax())
                    return "after a partial reset", _what(found, _SEEDS)
    return None


# --- another process ---


def digests(subject: Subject) -> dict[str, list[str]]:
    """Digests of what comes out of some episodes, step by step."""
    steps = play(subject, _SEEDS[:4], policy=subject.policy, threads=1)
    found: dict[str, list[str]] = {}
    for step in steps:
        for name, value in step.items():
            digest = hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
            found.setdefault(name, []).append(digest[:16])
    return found


def _in_a_fresh_process(subject: Subject) -> str:
    """What differs there, in words."""
    if subject.file is None and subject.is_own:
        subject.add("episodes", "note", "registered without a file: no run in a fresh process")
        return ""
    target = subject.id if subject.file is None else f"{subject.file}:{subject.id}"
    seed = "1" if os.environ.get("PYTHONHASHSEED") != "1" else "2"
    run = subprocess.run(
        [sys.executable, "-c", _PROGRAM, "--digests", target],
        env={**os.environ, "PYTHONHASHSEED": seed},
        capture_output=True,
        text=True,
        timeout=_FRESH_SECONDS,
        check=False,
    )
    if run.returncode != 0:
        last = (run.stderr.strip().splitlines() or ["no message"])[-1]
        return f"the task fails in a fresh process: {last}"
    other, own = json.loads(run.stdout), digests(subject)
    for name in sorted(own, key=causes_first):
        unlike = [i for i, (one, two) in enumerate(zip(own[name], other[name])) if one != two]
        if unlike:
            return (
                f"{name} differs in a fresh process, first in its value number {unlike[0] + 1}: "
                "something depends on the order of a set, on hash(), on the time or on files"
                + _lines(subject)
            )
    return ""
