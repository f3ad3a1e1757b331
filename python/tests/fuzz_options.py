"""Fuzzing of the Python API's arguments, by number.

    python python/tests/fuzz_options.py [COUNT [FIRST]]

Case n is the same on every machine: a call with one or two arguments that are of any type and size.
It is refused by an error of engram's own, of one line that terminals can show, or it is taken, and
then what it made works. Nothing is written anywhere.
"""

from __future__ import annotations

import collections
import decimal
import faulthandler
import fractions
import inspect
import os
import random
import signal
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import engram

ID = "RememberColor3-VLA-v0"
SECONDS = 60  # that one case may take

_OPTIONS = sorted({*inspect.signature(engram.VectorEnv).parameters} - {"id", "num_envs"})
# Valid but expensive: a million environments, a thousand threads.
_DEAR = {"num_envs", "threads", "image_size"}


class Index:
    """True for values that count as integers."""

    def __index__(self) -> int:
        return 2


def value(rng: random.Random) -> Any:
    """Anything."""
    numbers = [0, 1, -1, 2, 7, -(2**31), 2**31, 2**63, 2**64, 10**400, -0.0, 0.5, 1.5, 1e308]
    numbers += [float("nan"), float("inf"), -float("inf"), True, False, 1j, decimal.Decimal("1.5")]
    numbers += [fractions.Fraction(1, 3), Index(), np.int8(1), np.uint64(2**63), np.float32(0.5)]
    numbers += [np.bool_(True), np.float64("nan"), np.int64(-1), np.array(3), np.array([3])]
    texts = [
        "",
        "no",
        "off",
        "1",
        "0.5",
        "state",
        "rgb",
        "cpu",
        "oracle",
        "x" * 100_000,
        "é",
        "\ud800",
    ]
    texts += ["a\0b", "\x1b[2J", "a\nb", "../../etc/passwd", "/dev/zero", "%s%n", ID, f"{ID}\0x"]
    texts += ["engram/" + ID, "engram/", "{}", "[]", "null", "target", "next-step", "DISABLED"]
    others = [
        None,
        [],
        (),
        {},
        set(),
        b"",
        b"cpu",
        [None],
        [[]],
        [1, 2],
        (64, 64),
        [64, 64, 64],
        {1: 2},
    ]
    others += [object(), int, len, ..., np.array([]), np.zeros((2, 2)), np.array(["a"]), range(3)]
    others += [
        np.array([1, 2], object),
        {"target": 1},
        {"x\0": 1},
        {"target": None},
        ["base_camera"],
    ]
    others += [
        ["base_camera"] * 1000,
        ["\x1b"],
        {"target": [0] * 1000},
        {"strict": 1},
        {"strict": "1"},
    ]
    others += [
        {"COLORS": 3},
        {"COLORS": [1, 2]},
        {"EMPTY_PHASE_STEPS": (1, 3)},
        {"COLORS": object()},
    ]
    others += [
        {"target": float("nan")},
        {"strict": float("nan")},
        {"COLORS": float("nan")},
        Path("x"),
    ]
    return rng.choice([rng.choice(numbers), rng.choice(texts), rng.choice(others)])


def plausible(name: str, rng: random.Random) -> Any:
    """A value at or beyond the edge of what an option may be."""
    edges: dict[str, list[Any]] = {
        "num_envs": [0, 1, 2, 1_000_001, -5],
        "threads": [0, 1, 2, -1, 1025],
        "image_size": [0, 1, 2, 64, (1, 3), (64, 0), -1, 4097, (4097, 1)],
        "render_size": [0, 1, 2, 64, (1, 3), (64, 0), -1, 4097, (4097, 1)],
        "pins": [{"target": i} for i in (0, 2, 3, -1, 1.5, 2**53)],
        "constants": [{"CUE_PHASE_STEPS": v} for v in (1, 0, -1, (3, 1), [1, 2, 3], 10**9, "x")],
        "cameras": [["base_camera"], ["base_camera", "none"], ["base_camera"] * 2, "base_camera"],
        "substeps": [0, 1, 5, 1000, 1001],
        "chunk": [0, 1, 2**31 - 1],
        "lanes": [0, 1, 2, 3, 8, 16],
        "rotation_sign": [-1, 0, 1],
        "robot_init_qpos_noise": [0, 1, 1.0001, 0.5, -0.1],
        "max_episode_steps": [0, 1, 10, 1_000_000, 10**7],
    }
    return rng.choice(edges.get(name, [value(rng)]))


# --- calls ---


def make(rng: random.Random) -> Any:
    """A batch, stepped."""
    options: dict[str, Any] = {"num_envs": 2, "threads": 1}
    for name in rng.choices(["num_envs", *_OPTIONS], k=rng.choice([1, 1, 2])):
        given = plausible(name, rng) if rng.random() < 0.4 else value(rng)
        if name in _DEAR and _is_dear(given):
            given = -1
        options[name] = given
    id = value(rng) if rng.random() < 0.1 else ID
    maker: Callable[..., Any] = engram.make_vec
    if rng.random() < 0.2:
        options.pop("num_envs", None)
        maker = engram.make
    env = maker(id, **options)
    try:
        env.reset()
        space = env.action_space
        env.step(np.zeros(space.shape, np.float32))
    finally:
        env.close()


def _is_dear(given: Any) -> bool:
    try:
        sizes = np.asarray(given, np.float64)
    except (TypeError, ValueError, OverflowError):
        return False
    return bool((sizes > 100).any()) and bool((sizes <= 1_000_000).all())


class Open:
    """A batch that many calls are made to."""

    def __init__(self) -> None:
        self.env = engram.make_vec(ID, 2, threads=1)
        self.env.reset()
        self.bytes = self.env.save()

    def call(self, rng: random.Random) -> Any:
        """One call; afterwards the batch is as good as before."""
        env = self.env
        one = value(rng)
        calls: list[Callable[[], Any]] = [
            lambda: env.reset(seed=one),
            lambda: env.reset(seed=[one, 1]),
            lambda: env.reset(options=one),
            lambda: env.reset(options={"pins": one}),
            lambda: env.reset(options={"constants": one}),
            lambda: env.reset(options={"reset_mask": one}),
            lambda: env.reset(
                options={"reset_mask": np.array([True, False]), "pins": {"target": one}}
            ),
            lambda: env.step(one),
            lambda: env.step([one] * 2),
            lambda: env.step(np.full((2, 7), np.nan)),
            lambda: env.step_async(one),
            lambda: env.act(one),
            lambda: env.act("zero", out=one),
            lambda: env.frame(index=one),
            lambda: env.frame(camera=one),
            lambda: env.frame(size=rng.choice([one, 0, 4097, (1, 2), (4097, 1), -1])),
            lambda: env.save(one),
            lambda: env.restore(one),
            lambda: env.restore(self.damaged(rng)),
            lambda: env.restore(self.bytes, one),
            lambda: engram.describe(one),
            lambda: engram.describe(ID, **{rng.choice(_OPTIONS): -1}),
        ]
        try:
            return rng.choice(calls)()
        finally:
            env.restore(self.bytes)
            env.step(np.zeros((2, 7), np.float32))

    def damaged(self, rng: random.Random) -> bytes:
        """Bytes of a snapshot that are not what they were."""
        changed = bytearray(self.bytes)
        changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)
        return bytes(changed[: rng.choice([len(changed), rng.randrange(len(changed))])])


def evaluate(rng: random.Random) -> Any:
    """An evaluation of no episodes, or one that is refused."""
    names = ["ids", "episodes", "seed", "num_envs", "threads", "obs", "renderer", "rules"]
    names += [
        "task_options",
        "constants",
        "perturb",
        "name",
        "config",
        "output",
        "resume",
        "progress",
        "policy",
    ]
    name = rng.choice(names)
    given = value(rng)
    options: dict[str, Any] = {"episodes": 1, "num_envs": 1, "threads": 1, "obs": "state"}
    options |= {"policy": no_policy, "ids": ID, name: given}
    # Results would be written, or a thousand episodes be played.
    if name in ("output", "resume") and isinstance(given, (str, bytes, Path)):
        options[name] = "" if name == "output" else "/nowhere"
    if name == "policy" and callable(given):
        options[name] = no_policy  # errors of other libraries
    if name in ("episodes", "num_envs", "threads") and _is_dear(given):
        options[name] = -1
    return engram.evaluate(options.pop("policy"), options.pop("ids"), **options)


class Stop(engram.Error):
    """Raised by the policy: the arguments were accepted."""


def no_policy(_: Any) -> Any:
    """A policy that ends its evaluation."""
    raise Stop("taken")


def register(rng: random.Random) -> Any:
    """A variant, or a file of variants."""
    options = {"id": f"Fuzz-{rng.random()}x", "base": ID, "constants": {"CUE_PHASE_STEPS": (0, 1)}}
    options[rng.choice([*options, "instruction"])] = value(rng)
    if rng.random() < 0.3:
        return engram.load_variants(value(rng))
    if isinstance(options["id"], str) and options["id"].endswith("-v0"):
        options["id"] = 3  # not to be registered for good
    return engram.register(**options)


# --- what must hold ---


def problem(number: int, batch: Open) -> tuple[str, str | None]:
    """Plays a case; returns what came of it, and what does not hold."""
    rng = random.Random(number)
    call = rng.choices([make, batch.call, evaluate, register], [40, 40, 15, 5])[0]
    try:
        call(rng)
    except Stop:
        return "accepted", None
    except engram.InternalError as error:
        return "internal", f"internal error: {error}"
    except engram.Error as error:
        message = str(error)
        if not message.isprintable() or not message:
            return "refused", f"a message that is no line: {message!r}"
        if len(message) > 5000:
            return "refused", f"a message of {len(message)} letters"
        return "refused", None
    except TypeError as error:
        if "keyword argument" in str(error) or "must be strings" in str(error):
            return "refused", None
        return "raised", f"TypeError: {str(error)[:200]}"
    except Exception as error:
        return "raised", f"{type(error).__name__}: {str(error)[:200]}"
    return "accepted", None


def play(first: int, count: int) -> tuple[collections.Counter, list[str]]:
    """Plays cases; returns how many were refused and accepted, and what does not hold."""
    counts: collections.Counter = collections.Counter()
    findings: list[str] = []
    batch = Open()
    before = Path.cwd()

    def too_late(*_: Any) -> None:
        raise TimeoutError(f"more than {SECONDS} s")

    signal.signal(signal.SIGALRM, too_late)
    with tempfile.TemporaryDirectory() as place:
        os.chdir(place)
        try:
            for number in range(first, first + count):
                signal.alarm(SECONDS)
                faulthandler.dump_traceback_later(2 * SECONDS, exit=True)  # if it is stuck in C
                outcome, found = problem(number, batch)
                signal.alarm(0)
                counts[outcome] += 1
                if found:
                    findings.append(f"case {number}: {found}")
                if os.listdir(place):
                    findings.append(f"case {number}: wrote {os.listdir(place)}")
                    break
        finally:
            faulthandler.cancel_dump_traceback_later()
            os.chdir(before)
            batch.env.close()
    return counts, findings


def main() -> int:
    """The command."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    first = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    counts, findings = play(first, count)
    print(*findings, sep="\n")
    print(f"options: {count} cases, {dict(counts)}, {len(findings)} findings")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
