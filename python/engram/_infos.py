"""Infos in Gymnasium's forms: masked columns of a batch, and rows of single environments."""

from __future__ import annotations

from typing import Any

import numpy as np

# Infos that are NaN throughout while there are none yet: then their mask is False.
_SOMETIMES = frozenset(["reward_dict"])


def masked(
    views: dict[str, np.ndarray], instructions: np.ndarray | None, which: np.ndarray
) -> dict[str, Any]:
    """Every name beside a mask of the environments that it holds for."""
    info: dict[str, Any] = {}
    for name, view in views.items():
        info[name] = view
        info[f"_{name}"] = which & _is_known(view) if name in _SOMETIMES else which
    if instructions is not None:
        info["language_instruction"] = instructions
        info["_language_instruction"] = which
    return info


def row(
    views: dict[str, np.ndarray], instructions: np.ndarray | None, index: int
) -> dict[str, Any]:
    """One environment's: scalars and copies."""
    info: dict[str, Any] = {
        name: view[index].copy() if view.ndim > 1 else _scalar(view[index])
        for name, view in views.items()
        if name not in _SOMETIMES or _is_known(view)[index]
    }
    if instructions is not None:
        info["language_instruction"] = instructions[index]
    return info


def _is_known(view: np.ndarray) -> np.ndarray:
    return ~np.isnan(view).reshape(len(view), -1).all(axis=1)


def _scalar(value: Any) -> Any:
    return bool(value) if isinstance(value, np.bool_) else value
