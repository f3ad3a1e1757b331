"""Constants at their least and greatest values."""

from __future__ import annotations

from typing import Any

from engram.errors import Error, InvalidArgumentError
from engram.kit.checks.intervals import interval
from engram.kit.checks.play import StoppedError
from engram.kit.checks.scripts import successes
from engram.kit.checks.subject import COMMON, Subject


def check(subject: Subject) -> None:
    refused, solved, wrong = [], 0, 0
    for constant in subject.description["changeable"]:
        if constant["name"] in COMMON:
            continue
        for value in _ends(constant):
            words = f"{constant['name']} = {value}"
            result = _attempt(subject, constant["name"], value)
            if isinstance(result, tuple):
                wrong += result[0] == "wrong"
                subject.add("constants", result[0], f"with {words} {result[1]}", constant=words)
            elif result is not None:
                refused.append(words)
            else:
                solved += 1
    if not wrong:
        more = f"; refused with a sentence: {', '.join(refused)}" if refused else ""
        subject.add("constants", "ok", f"{solved} least and greatest values work{more}")


def _ends(constant: dict[str, Any]) -> list[Any]:
    kind = constant["kind"]
    if kind == "name":
        return list(constant["names"])
    low, high = constant.get("low"), constant.get("high")
    if low is None or high is None:
        return []
    if "range" in kind:
        cast: Any = int if "integer" in kind else float
        return [(cast(low), cast(low)), (cast(high), cast(high))]
    if kind == "integer":
        return [int(low), int(high)]
    return [low, high] if kind == "real" else []


def _attempt(subject: Subject, name: str, value: Any) -> tuple[Any, str] | str | None:
    """A verdict and what is wrong; or the words of a refusal; None: all is well."""
    options = {"constants": {name: value}}
    try:
        with subject.batch(1, **options):
            pass
    except InvalidArgumentError as error:
        return str(error)
    except Exception as error:
        return "wrong", (
            f"the task raises {type(error).__name__}: {error}; build() has to refuse such values "
            "with an InvalidArgumentError, or the constant's low and high are to be narrower"
        )
    count = 16 if subject.fast else 32
    policy = subject.policy
    try:
        found = successes(subject, policy, episodes=count, **options)[0]
    except (Error, StoppedError) as error:
        return "wrong", f"an episode fails: {error}"
    if "oracle" not in subject.scripts or interval(found, count)[1] >= subject.floor:
        return None
    text = f"oracle() succeeds in {found} of {count} episodes, oracle_floor is {subject.floor}"
    if not subject.is_own:
        return "note", text
    return "wrong", text + "; narrower bounds, or a refusal in build(), needed"
