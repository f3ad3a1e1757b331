"""Meaning of the numbers of an action: answers beside the oracle's actions in the same steps."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from engram.servers.checking.findings import Finding
from engram.servers.conventions import ACTIONS, to_engram

Array = npt.NDArray[np.float64]

_MOVES = 0.02  # standard deviation of an oracle's number that moves
_CLEAR = 0.05  # error that is worth a word
_AGREES = 0.8  # correlation
_SPACINGS = (1, 2, 3)  # control steps between the actions of a chunk


@dataclasses.dataclass(frozen=True)
class Number:
    """A number of an action: range of the answers, and the oracle's number that is most like it.

    like, correlation: None where neither moves.
    scale: Of the answers, in units of the oracle's; None where they do not agree.
    """

    name: str
    low: float
    high: float
    like: str | None
    correlation: float | None
    scale: float | None


@dataclasses.dataclass(frozen=True)
class _Part:
    """Numbers that belong together, and mistakes that are made with them."""

    name: str
    columns: slice
    mistakes: dict[str, Callable[[Array], Array]]


def _negated(values: Array) -> Array:
    return -values


def _reversed(values: Array) -> Array:
    return values[:, ::-1]


_TCP_PARTS = (
    _Part(
        "translation",
        slice(0, 3),
        {
            "with the opposite sign": _negated,
            "in the order y, x, z": lambda values: values[:, [1, 0, 2]],
            "in the order z, y, x": _reversed,
        },
    ),
    _Part(
        "rotation",
        slice(3, 6),
        {
            "with the opposite sign": _negated,
            "in the order yaw, pitch, roll": _reversed,
            "in degrees": np.radians,
        },
    ),
)
_GRIPPER = _Part("gripper", slice(-1, None), {"with open and closed exchanged": _negated})
_JOINT_PARTS = (
    _Part(
        "joints",
        slice(0, -1),
        {
            "with the opposite sign": _negated,
            "in degrees": np.radians,
            "in the opposite order": _reversed,
        },
    ),
)


def meant(convention: str, answers: Array) -> Array:
    """Answers (n, A) as actions of engram."""
    return np.asarray(to_engram(convention, answers), np.float64)


# --- each number ---


def numbers_of(names: Sequence[str], actions: Array, oracle: Array) -> list[Number]:
    """A line for each number; actions and oracle: (n, A)."""
    like = _correlations(actions, oracle)
    result = []
    for i, name in enumerate(names):
        low, high = float(actions[:, i].min()), float(actions[:, i].max())
        if np.isnan(like[i]).all():
            result.append(Number(name, low, high, None, None, None))
            continue
        best = int(np.nanargmax(np.abs(like[i])))
        r = float(like[i, best])
        scale = None
        if abs(r) >= _AGREES:
            scale = r * float(actions[:, i].std() / oracle[:, best].std())
        result.append(Number(name, low, high, names[best], r, scale))
    return result


def _correlations(actions: Array, oracle: Array) -> Array:
    """Correlation of each number with each of the oracle's; NaN where one does not move."""
    count = actions.shape[1]
    result = np.full((count, count), np.nan)
    for i in range(count):
        for j in range(count):
            if actions[:, i].std() > 1e-6 and oracle[:, j].std() > _MOVES:
                result[i, j] = np.corrcoef(actions[:, i], oracle[:, j])[0, 1]
    return result


# --- all of them ---


@dataclasses.dataclass(frozen=True)
class _Reading:
    """A way to read a part of the answers.

    mistake: "" is none.
    error: Mean distance to the oracle's numbers.
    size: Mean distance of these to 0.
    """

    convention: str
    mistake: str
    error: float
    size: float


def findings_of(convention: str, answers: Array, oracle: Array) -> list[Finding]:
    """Likely mistakes; answers: (n, A) as the server sends them, oracle: (n, A) of engram."""
    parts = _readings(convention, answers, oracle)
    wrong = {name: least for name, readings in parts.items() if (least := _better(readings))}
    if not wrong:
        return _scales(convention, answers, oracle)
    own = {name: readings[0].error for name, readings in parts.items()}
    for other in ACTIONS:
        plain = {
            name: reading.error
            for name, readings in parts.items()
            for reading in readings
            if reading.convention == other and not reading.mistake
        }
        if all(
            plain.get(name, np.inf) <= (1.2 * wrong[name].error if name in wrong else own[name])
            for name in parts
        ):
            return [_other_convention(other, {name: (own[name], plain[name]) for name in wrong})]
    return [_wrong_part(convention, name, own[name], least) for name, least in wrong.items()]


def _better(readings: list[_Reading]) -> _Reading | None:
    """A reading that explains what the usual one, the first, does not."""
    own = readings[0]
    if own.error < 0.3 * own.size:
        return None
    least = min(readings, key=lambda r: (r.error, r.convention != own.convention))
    return least if least.error < 0.5 * min(own.error, own.size) else None


def _readings(convention: str, answers: Array, oracle: Array) -> dict[str, list[_Reading]]:
    """Ways to read the parts that the oracle moves, and the gripper; the convention's own first."""
    tcp = answers.shape[1] == 7
    names = [convention, *(name for name in ACTIONS if name != convention)] if tcp else ["mikasa"]
    result = {}
    for part in (*(_TCP_PARTS if tcp else _JOINT_PARTS), _GRIPPER):
        moving = (oracle[:, part.columns].std(0) > _MOVES) | (part is _GRIPPER)
        if not moving.any():
            continue
        size = float(np.abs(oracle[:, part.columns])[:, moving].mean())
        readings = []
        for name in names:
            for mistake, undo in {"": lambda values: values, **part.mistakes}.items():
                if part is _GRIPPER:  # whose exchange depends on the convention's numbers
                    read = meant(name, answers)
                    read[:, part.columns] = undo(read[:, part.columns])
                else:
                    read = answers.astype(np.float64)
                    read[:, part.columns] = undo(read[:, part.columns])
                    read = meant(name, read)
                error = float(_error(read, oracle)[part.columns][moving].mean())
                readings.append(_Reading(name, mistake, error, size))
        result[part.name] = readings
    return result


def _error(actions: Array, oracle: Array) -> Array:
    """Mean distance of each number, within the action space."""
    if actions.shape[1] == 7:
        actions, oracle = np.clip(actions, -1, 1), np.clip(oracle, -1, 1)
    return np.abs(actions - oracle).mean(0)


def _other_convention(name: str, errors: dict[str, tuple[float, float]]) -> Finding:
    falls = ", ".join(f"{part} {own:.2f} > {least:.2f}" for part, (own, least) in errors.items())
    return Finding(
        True,
        f"the distance to the oracle's falls ({falls}) if actions are read as {name}",
        f"the server sends actions of {name}",
        f"--server-actions {name}",
    )


def _wrong_part(convention: str, part: str, own: float, least: _Reading) -> Finding:
    read = f"as {least.convention}" if least.convention != convention else ""
    how = " ".join(filter(None, (read, least.mistake)))
    return Finding(
        True,
        f"{part}: the distance to the oracle's falls from {own:.2f} to {least.error:.2f} if it is "
        f"read {how}",
        f"the server sends {part} {how}",
        "docs/policy_servers.md#meaning-of-actions",
    )


def _scales(convention: str, answers: Array, oracle: Array) -> list[Finding]:
    """Numbers that agree with the oracle's in all but their scale; answers out of all bounds."""
    actions = meant(convention, answers)
    found = []
    arm = actions[:, :-1]
    beyond = float((np.abs(arm) > 1.5).mean())
    if actions.shape[1] == 7 and beyond > 0.2:
        found.append(
            Finding(
                True,
                f"{beyond:.0%} of the arm's numbers are beyond 1.5, and are cut off at 1",
                "actions in other units, or unnormalised ones where normalised ones are meant",
            )
        )
    r = np.diag(_correlations(actions, oracle))
    for i in range(actions.shape[1] - 1):
        scale = r[i] * actions[:, i].std() / oracle[:, i].std() if r[i] >= _AGREES else 1.0
        if not 0.4 < scale < 2.5:
            found.append(
                Finding(
                    True,
                    f"number {i} goes with the oracle's and is {scale:.3g} times as large",
                    "actions in other units, or normalised ones that the server has not "
                    "multiplied by the statistics of its data set",
                )
            )
    return found


def agreement(actions: Array, oracle: Array) -> float | None:
    """Mean correlation of the arm's numbers that move; None: none moves."""
    r = np.diag(_correlations(actions, oracle))[:-1]
    return None if np.isnan(r).all() else float(np.nanmean(r))


# --- chunks ---


def spacing_of(chunks: Sequence[tuple[int, Array]], oracle: Array) -> Finding | None:
    """Whether the actions of a chunk are a control step apart.

    Args:
        chunks: The step of each question, and its answer as actions of engram.
        oracle: The episode's actions, (T, A).
    """
    longest = min(len(chunk) for _, chunk in chunks)
    if longest < 3:
        return None
    errors = []
    for spacing in _SPACINGS:
        distances = [
            _error(chunk[i : i + 1], oracle[step + spacing * i][None])[:-1].mean()
            for step, chunk in chunks
            for i in range(1, longest)
            if step + _SPACINGS[-1] * i < len(oracle)
        ]
        if not distances:
            return None
        errors.append(float(np.mean(distances)))
    best = int(np.argmin(errors))
    if best == 0 or errors[0] < _CLEAR / 2 or errors[best] > 0.6 * errors[0]:
        return None
    return Finding(
        True,
        f"actions of a chunk are nearest to the oracle's {_SPACINGS[best]} steps apart "
        f"({errors[best]:.2f}, one step apart {errors[0]:.2f})",
        f"the policy acts {20 / _SPACINGS[best]:g} times a second; the robot acts 20 times",
    )
