"""Episodes run to their end, and rewards, observations and infos are what they should be."""

from __future__ import annotations

from typing import Any

import numpy as np

from engram.kit.checks.placing import Placing
from engram.kit.checks.play import Player
from engram.kit.checks.subject import Subject

_ROUNDING = 1e-6
_METHODS = {"_reward": "reward()", "_state": "observe()", "prop_pos": "place() or move()"}


def check(subject: Subject) -> None:
    """Plays oracle, random, blind and sweep episodes; StoppedError comes out."""
    found = len(subject.findings)
    placing = Placing(subject) if subject.is_own else None
    for policy in (*subject.scripts, "random"):
        _play(subject, policy, placing)
        if len(subject.findings) > found:
            return  # others would only say it again
    with subject.batch(4, obs_mode="objects") as env:
        player = Player(subject, env, None)
        player.begin(range(4))
        for step in range(1, min(subject.horizon, 20) + 1):
            outputs = player.step(np.zeros(env.action_space.shape))
            if _check_values(subject, "zero", outputs, step):
                return
            if not env.observation_space.contains(outputs["objects"]):
                subject.add("runs", "wrong", f"objects leave their space in step {step}")
                return
    if placing is not None:
        placing.report()
    if len(subject.findings) == found:
        subject.add("runs", "ok", "episodes run to their end; rewards, observations and infos are "
                    "finite and within their bounds")  # fmt: skip


def _play(subject: Subject, policy: str, placing: Placing | None) -> None:
    """Episodes of one policy; the first thing that is wrong ends them."""
    count = 8 if subject.fast else 32
    with subject.batch(count) as env:
        player = Player(subject, env, policy)
        player.begin(range(100, 100 + count))
        if placing is not None:
            placing.note(0)
        least = {True: np.inf, False: np.inf}
        most = {True: -np.inf, False: -np.inf}
        for step in range(1, subject.horizon + 1):
            outputs = player.step()
            if placing is not None:
                placing.note(step)
            if _check_values(subject, policy, outputs, step):
                return
            for kind in (True, False):
                rewards = outputs["reward"][outputs["info success"] == kind]
                least[kind] = min(least[kind], rewards.min(initial=np.inf))
                most[kind] = max(most[kind], rewards.max(initial=-np.inf))
        if most[False] >= 1 - _ROUNDING or (most[False] >= least[True] and least[True] >= 1):
            subject.add(
                "runs", "wrong",
                f"reward(): a step without success has a normalized reward of {most[False]:.3f} "
                f"with {policy} actions, as much as one with success; shaped rewards have to stay "
                "below success_reward", most_without_success=float(most[False]),
            )  # fmt: skip
        if most[True] > 1 + _ROUNDING:
            subject.add(
                "runs", "wrong",
                f"reward(): a step with success has a normalized reward of {most[True]:.3f}, more "
                "than 1; success_reward has to be the greatest reward of a step",
                most_with_success=float(most[True]),
            )  # fmt: skip


def _check_values(subject: Subject, policy: str, outputs: dict[str, Any], step: int) -> bool:
    """Whether a step has a value that is wrong."""
    if outputs["info unstable"].any():
        env = int(outputs["info unstable"].argmax())
        subject.add(
            "runs", "wrong",
            f"step {step} of environment {env} with {policy} actions is unstable: "
            + _reason(subject, env), step=step,
        )  # fmt: skip
        return True
    for name, value in outputs.items():
        finite = np.isfinite(value.reshape(len(value), -1)).all(axis=1)
        if finite.all() or name == "info reward_dict":
            continue
        method = "reward()" if name == "reward" else "observe()"
        where = method if name == "reward" or name.startswith("state field") else name
        subject.add(
            "runs", "wrong",
            f"{where}: {name} is not finite in step {step} of environment {int(finite.argmin())} "
            f"with {policy} actions", step=step,
        )  # fmt: skip
        return True
    return False


def _reason(subject: Subject, env: int) -> str:
    """Why physics gave up."""
    if subject.is_own:
        for column, method in _METHODS.items():
            if not np.isfinite(subject.view(column)[env]).all():
                return f"{method} has given a value that is not finite"
    return "physics diverged; props that overlap, or great velocities? See place()"
