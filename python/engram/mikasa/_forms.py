"""Forms of constants: those of the original's class attributes, from engram's lists and numbers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from engram.mikasa import _families
from engram.mikasa._torch import torch

_LISTS_OF_ARRAYS = ("FLASH_COLORS", "CUBE_COLORS")
_TENSORS = ("COLOR_RGBA",)
_PALETTE = "COLOR_PALETTE"
_MAPPING = "COLOR_MAPPING"
_TUPLES = ("VELOCITY_RANGE",)
_WHOLE = ("MANIP_WIDTH_SCALE",)
_SHELLS = (*_WHOLE, "HEIGHT_OFFSET")  # of shell games without a lamp


def of_task(constants: Mapping[str, Any], family: str = "") -> dict[str, Any]:
    """Constants of a task in the original's forms.

    Colours and half sizes are float32 arrays, colours to be combined are float64 arrays by number,
    colours of lamps a tensor, ranges of speeds tuples, ranges of steps lists; some lengths are
    whole numbers.
    """
    whole = _WHOLE if family in _families.LAMPS or family not in _families.SHELL_GAMES else _SHELLS
    return {
        name: int(value) if name in whole and value == int(value) else _form(name, value)
        for name, value in constants.items()
    }


def _form(name: str, value: Any) -> Any:
    if isinstance(value, Mapping):  # JSON has texts for keys
        numbered = {int(key): one for key, one in value.items()}
        if name == _PALETTE:
            return {key: np.array(rgba, np.float64) for key, rgba in numbered.items()}
        if name == _MAPPING:
            return {key: (color, list(rgba)) for key, (color, rgba) in numbered.items()}
        return numbered
    if not isinstance(value, list):
        return value
    if name in _LISTS_OF_ARRAYS:
        return [np.array(one, np.float32) for one in value]
    if name in _TENSORS:
        return torch.tensor(value, dtype=torch.float32)
    if name.endswith(("_COLOR", "_HALF_SIZE")):
        return np.array(value, np.float32)
    return tuple(value) if name in _TUPLES else value


def same(one: Any, other: Any) -> bool:
    """Equality of values in any form; numbers are equal in single precision."""
    if isinstance(one, Mapping) or isinstance(other, Mapping):
        return (
            isinstance(one, Mapping)
            and isinstance(other, Mapping)
            and list(map(str, one)) == list(map(str, other))
            and all(same(*pair) for pair in zip(one.values(), other.values()))
        )
    one, other = _listed(one), _listed(other)
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(same(*pair) for pair in zip(one, other))
    if isinstance(one, (int, float)) and isinstance(other, (int, float)):
        return bool(np.float32(one) == np.float32(other))
    return bool(one == other)


def _listed(value: Any) -> Any:
    if hasattr(value, "tolist"):
        return value.tolist()
    return list(value) if isinstance(value, tuple) else value
