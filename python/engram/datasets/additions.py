"""What demonstrations hold beside colours, proprio and actions, by options of `engram collect`."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from engram.datasets import checks
from engram.datasets.checks import DatasetError

# The options' names, and those of the entries in the metadata.
ADDITIONS = ("labels", "depth", "segmentation", "state", "objects")
LABELS, DEPTH, SEGMENTATION, STATE, OBJECTS = ADDITIONS
# Images with one number per pixel: mm, or an index into the names of segments.
MAPS = (DEPTH, SEGMENTATION)
MAP_TYPE = np.uint16
MAPS_SHAPE = (*checks.CAMERA_SHAPE[:2], 2)  # base camera, wrist camera
MAP_SHAPE = (*checks.CAMERA_SHAPE[:2], 1)
# Rows of numbers, those of the observation modes of these names; of a set one at most.
ROWS = (STATE, OBJECTS)
SEGMENT_NAMES = "segmentation_names"


def map_keys(name: str) -> tuple[str, str]:
    """Observations of the base and the wrist camera, in RLDS and HDF5: depth or segmentation."""
    return name, f"wrist_{name}"


def of_metadata(origin: dict[str, Any]) -> frozenset[str]:
    """The additions that metadata.json lists in its entry `engram`."""
    return frozenset(name for name in ADDITIONS if origin.get(name) not in (None, False))


def chosen(**options: bool) -> tuple[str, ...]:
    """The names of the options that are true, in their order."""
    return tuple(name for name in ADDITIONS if options.get(name))


def require(path: Any, present: Iterable[str], asked: Iterable[str]) -> None:
    """Refuses demonstrations that lack what is asked for."""
    for name in ADDITIONS:
        if name in asked and name not in present:
            raise DatasetError(f"{name}: '{path}' has none; `engram collect --{name}` writes them")


def check_segments(names: list[str], segmentation: np.ndarray) -> None:
    """Refuses pixels without a name."""
    for name in names:
        checks.instruction(SEGMENT_NAMES, name)
    highest = segmentation.max(initial=0)
    if highest >= len(names):
        raise DatasetError(f"{SEGMENTATION}: {highest} given; of {len(names)} names")


class SegmentNames:
    """The names of segments of a data set, which are the same in all its episodes."""

    def __init__(self) -> None:
        self.names: list[str] | None = None

    def add(self, names: list[str] | None) -> None:
        """names: those of an episode; None if it has no segmentation."""
        if self.names is None:
            self.names = names
        elif names != self.names:
            raise DatasetError(f"{SEGMENT_NAMES}: episodes have different ones; the same needed")
