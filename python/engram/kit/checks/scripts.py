"""Success rates of the scripts: the oracle solves the task, guesses are at chance."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from engram.errors import InvalidArgumentError
from engram.kit.checks.intervals import interval
from engram.kit.checks.play import Player
from engram.kit.checks.subject import Subject

_SEED = 5000


def check(subject: Subject) -> None:
    _check_oracle(subject)
    _check_blind(subject)
    _check_sweep(subject)
    zero = successes(subject, "zero")[0]
    if zero:
        subject.add(
            "scripts", "wrong",
            f"zero actions succeed in {zero} of {subject.episodes} episodes: evaluate() finds "
            "success without any act; let it count in the last phase only, or begin farther away",
            zero=zero, episodes=subject.episodes,
        )  # fmt: skip
    else:
        subject.add("scripts", "ok", f"zero actions succeed in 0 of {subject.episodes} episodes")


def successes(
    subject: Subject,
    policy: str,
    *,
    episodes: int | None = None,
    pins: Mapping[str, Any] | None = None,
    **options: Any,
) -> tuple[int, int, int]:
    """Episodes with a success, with an answer, and with a right first answer."""
    count = subject.episodes if episodes is None else episodes
    options = {"obs_mode": "none", **options}
    with subject.batch(count, **options) as env:
        player = Player(subject, env, policy)
        player.begin(range(_SEED, _SEED + count), pins)
        success = np.zeros(count, bool)
        for _ in range(env.description["horizon"]):
            outputs = player.step()
            success |= outputs["info success"].astype(bool)
            player.steps.clear()
        answered = int(outputs.get("info answered", np.zeros(1)).sum())
        right = int(outputs.get("info first_answer_correct", np.zeros(1)).sum())
        return int(success.sum()), answered, right


def _check_oracle(subject: Subject) -> None:
    if "oracle" not in subject.scripts:
        subject.add("scripts", "note", "there is no oracle(): whether the task can be solved in "
                    "time is not known")  # fmt: skip
        return
    count = subject.episodes
    found = successes(subject, "oracle")[0]
    high = interval(found, count)[1]
    figures = {"oracle": found, "episodes": count, "floor": subject.floor}
    text = f"oracle() succeeds in {found} of {count} episodes, oracle_floor is {subject.floor}"
    if high >= subject.floor:
        subject.add("scripts", "ok", text, **figures)
        return
    longer = _with_twice_the_time(subject)
    advice = "oracle() or evaluate() is to be changed, or oracle_floor"
    if longer is not None and longer > high:
        advice = (
            f"with twice the time in {longer:.0%} of them: the horizon, {subject.horizon}, is too "
            "short, or phases too long"
        )
    subject.add("scripts", "wrong", f"{text}: {advice}", **figures)


def _with_twice_the_time(subject: Subject, **options: Any) -> float | None:
    constants = {**options.pop("constants", {}), "max_episode_steps": 2 * subject.horizon}
    count = min(subject.episodes, 64)
    try:
        found = successes(subject, "oracle", episodes=count, constants=constants, **options)
    except InvalidArgumentError:
        return None
    return found[0] / count


def _check_blind(subject: Subject) -> None:
    if "blind" not in subject.scripts:
        subject.add("scripts", "note", "there is no blind(): chance is not measured")
        return
    count = subject.episodes
    found, _, right = successes(subject, "blind")
    rates = [("success", found, subject.description["chance"], "candidates or guess_rate")]
    if subject.description["answer"]:
        chance = subject.description["answer_chance"]
        rates.append(("a right first answer", right, chance, "candidates or answer_rate"))
    for what, number, chance, facts in rates:
        low, high = interval(number, count)
        text = f"blind() has {what} in {number} of {count} episodes ({low:.2f} to {high:.2f}), " \
               f"declared chance is {chance:.3f}"  # fmt: skip
        figures = {"blind": number, "episodes": count, "chance": chance}
        if low <= chance <= high:
            subject.add("scripts", "ok", text, **figures)
        elif number / count > chance:
            subject.add("scripts", "wrong", f"{text}: blind() knows what is hidden (it may use "
                        f"guess() and the scene only), or {facts} is wrong", **figures)  # fmt: skip
        else:
            subject.add("scripts", "wrong", f"{text}: blind() does not guess as well as it could, "
                        f"or {facts} is wrong", **figures)  # fmt: skip


def _check_sweep(subject: Subject) -> None:
    if "sweep" not in subject.scripts:
        subject.add("scripts", "note", "there is no sweep(): what can be reached without memory is "
                    "not measured")  # fmt: skip
        return
    count = subject.episodes
    found, answered, right = successes(subject, "sweep")
    text = f"sweep() succeeds in {found} of {count} episodes"
    figures: dict[str, Any] = {"sweep": found, "episodes": count}
    if "oracle" in subject.scripts:
        figures["oracle"] = successes(subject, "oracle")[0]
    if not subject.description["answer"]:
        verdict, more = _against_the_oracle(figures)
        subject.add("scripts", verdict, text + more, **figures)
        return
    chance = subject.description["answer_chance"]
    low = interval(right, max(answered, 1))[0]
    figures.update(answered=answered, right=right, chance=chance)
    text += f"; its first answer is right in {right} of {answered} (chance {chance:.3f})"
    if answered == 0 or low <= chance:
        subject.add("scripts", "ok", text, **figures)
    else:
        subject.add("scripts", "note", f"{text}: more than chance, though it has no memory; does "
                    "the scene show the answer?", **figures)  # fmt: skip


def _against_the_oracle(figures: dict[str, Any]) -> tuple[Any, str]:
    count, oracle = figures["episodes"], figures.get("oracle")
    if oracle is None:
        return "ok", ""
    if interval(figures["sweep"], count)[1] < oracle / count:
        return "ok", f", oracle() in {oracle}"
    return "note", f", oracle() in {oracle}: memory makes no difference here"
