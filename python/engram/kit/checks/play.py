"""Plays episodes and keeps all that comes out of them."""

from __future__ import annotations

import traceback
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from engram.errors import BadStateError, InvalidArgumentError, UnknownIdError
from engram.kit.checks.subject import Subject

IMAGE = 48  # pixels
_PACKAGE = str(Path(__file__).parents[2])


class StoppedError(Exception):
    """A task's own code has raised an exception."""

    def __init__(self, where: str, error: BaseException, state: str) -> None:
        super().__init__(f"{where}: {described(error)}{state}")


def described(error: BaseException) -> str:
    """Method, type, text and line of an exception."""
    own = [one for one in traceback.extract_tb(error.__traceback__) if _is_own(one.filename)]
    text = f"{type(error).__name__}: {error}"
    if isinstance(error, KeyboardInterrupt):
        text = "interrupted by Ctrl-C; a loop that does not end?"
    if not own:
        return text
    frame = own[-1]
    method = "" if frame.name == "<module>" else f"{frame.name}(), "
    return f"{method}line {frame.lineno} of {Path(frame.filename).name}: {text}"


def _is_own(file: str) -> bool:
    """Whether a file is a user's."""
    return not (file.startswith((_PACKAGE, "<frozen")) or "site-packages" in file)


def _state_of(env: Any, seeds: Sequence[int]) -> str:
    """What can be done with a batch after an exception, in words."""
    try:
        env.step(np.zeros(env.action_space.shape, np.float32))
        first = ""
    except BadStateError as error:
        first = f"; step() is refused then ({error})"
    except Exception:
        first = "; the next step() raises, too"
    try:
        env.reset(seed=list(seeds))
    except Exception:
        return first + "; reset() raises, too"
    return first + "; reset() works again"


class Player:
    """A batch whose outputs are collected step by step."""

    def __init__(self, subject: Subject, env: Any, policy: str | None) -> None:
        self.subject = subject
        self.env = env
        self.policy = policy
        self.steps: list[dict[str, Any]] = []
        self._fields = subject.description["state_fields"]

    def begin(self, seeds: Sequence[int], pins: Mapping[str, Any] | None = None) -> None:
        """New episodes everywhere."""
        options = {} if pins is None else {"pins": dict(pins)}
        try:
            observation, info = self.env.reset(seed=list(seeds), options=options)
        except (InvalidArgumentError, UnknownIdError):
            raise
        except Exception as error:
            raise StoppedError("reset", error, _state_of(self.env, seeds)) from error
        self.seeds = seeds
        self.steps = [self.outputs(observation, info)]

    def step(self, actions: Any = None, image: bool = False) -> dict[str, Any]:
        """A step with the policy's actions, or with others while the policy is asked as well."""
        number = len(self.steps)
        try:
            chosen = None if self.policy is None else self.env.act(self.policy)
            given = chosen if actions is None else actions
            observation, reward, terminated, truncated, info = self.env.step(given)
        except Exception as error:
            where = f"step {number}" + (f" with {self.policy} actions" if self.policy else "")
            raise StoppedError(where, error, _state_of(self.env, self.seeds)) from error
        outputs = self.outputs(observation, info)
        outputs.update(reward=reward, terminated=terminated, truncated=truncated)
        if chosen is not None:
            outputs["actions of " + str(self.policy)] = chosen
        if image:
            count = self.env.num_envs
            outputs["image"] = np.stack([self.env.frame(i, size=IMAGE) for i in range(count)])
        self.steps.append(outputs)
        return outputs

    def outputs(self, observation: Any, info: dict[str, Any]) -> dict[str, Any]:
        """What a reset, step or restore returned, by name."""
        found = {f"info {name}": np.array(value) for name, value in info.items()
                 if not name.startswith("_") and name != "language_instruction"}  # fmt: skip
        if isinstance(observation, dict):
            found.update({name: np.array(part) for name, part in observation.items()})
        elif self.env._arguments["obs_mode"] == "state":
            for field in self._fields:
                begin = field["offset"]
                part = observation[:, begin : begin + field["width"]]
                found["state field " + field["name"]] = part.copy()
        else:
            found["objects"] = observation.copy()
        return found


def play(
    subject: Subject,
    seeds: Sequence[int],
    *,
    policy: str | None,
    steps: int | None = None,
    actions: Sequence[Any] | None = None,
    pins: Mapping[str, Any] | None = None,
    images: Sequence[int] = (),
    **options: Any,
) -> list[dict[str, Any]]:
    """Outputs of episodes, step by step; actions: those to take instead of the policy's."""
    with subject.batch(len(seeds), **options) as env:
        player = Player(subject, env, policy)
        player.begin(seeds, pins)
        for i in range(subject.horizon if steps is None else steps):
            player.step(None if actions is None else actions[i], image=i + 1 in images)
        return player.steps


def actions_of(steps: list[dict[str, Any]], policy: str) -> list[Any]:
    return [step["actions of " + policy] for step in steps[1:]]


def rows_of(steps: list[dict[str, Any]], rows: Sequence[int]) -> list[dict[str, Any]]:
    """The outputs of some of the environments."""
    chosen = list(rows)
    return [{name: value[chosen] for name, value in step.items()} for step in steps]


def difference(
    one: list[dict[str, Any]], other: list[dict[str, Any]]
) -> tuple[str, int, int] | None:
    """Name, step and environment of the first output that differs in a bit."""
    for number, (first, second) in enumerate(zip(one, other)):
        for name in sorted(first.keys() & second.keys(), key=causes_first):
            unlike = different_rows(first[name], second[name])
            if unlike.any():
                return name, number, int(unlike.argmax())
    return None


def causes_first(name: str) -> tuple[int, str]:
    """An order in which what follows from other outputs comes behind them."""
    if name in ("info episode_return", "info success_once", "image"):
        return 3, name
    if name == "reward":
        return 1, name
    return (2 if name.startswith("info ") else 0), name


def different_rows(one: Any, other: Any) -> np.ndarray:
    """Rows (environments) that are not the same, bit for bit but for the kind of NaN."""
    equal = (one == other) | ((one != one) & (other != other))
    return ~equal.reshape(len(equal), -1).all(axis=1)
