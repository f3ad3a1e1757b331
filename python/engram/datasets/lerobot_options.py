"""Choices of a LeRobotDataset."""

from __future__ import annotations

import dataclasses
from typing import Any

from engram.datasets import checks
from engram.datasets.additions import ADDITIONS
from engram.datasets.checks import DatasetError
from engram.datasets.spaces import ANGLES, CONTROL_RATE

ENCODER = "libx264"  # which all trainers decode
VERSIONS = ("3.0", "2.1")
FRAMES = ("videos", "images", "auto")
MODALITIES = ("gr00t",)
FPS = CONTROL_RATE  # a second of the set is one of the robot; the published data have 10


@dataclasses.dataclass(frozen=True)
class Options:
    """What a LeRobotDataset is like.

    Attributes:
        version: Of the format, "3.0" or "2.1".
        fps: Frames per second, as time stamps have it; the robot makes 20 steps.
        frames: "videos", "images" (PNG, lossless) or "auto": images where they are no larger.
        codec: An encoder of FFmpeg for videos; None: libx264.
        angles: "continuous", or as the "benchmark" has them.
        modality: "gr00t" adds what Isaac-GR00T reads, to version 2.1.
        labels: Adds the demonstrations' labels, which are privileged.
        depth: Adds depth, as images whatever ``frames`` is.
        segmentation: The same for segmentation.
        state: Adds the row of the observation mode "state", which is privileged.
        objects: Adds the row of the mode "objects".
    """

    version: str = "3.0"
    fps: int = FPS
    frames: str = "videos"
    codec: str | None = None
    angles: str = ANGLES[0]
    modality: str | None = None
    labels: bool = False
    depth: bool = False
    segmentation: bool = False
    state: bool = False
    objects: bool = False

    def __post_init__(self) -> None:
        _one_of("version", self.version, VERSIONS)
        checks.whole_number("fps", self.fps, 1, checks.MAX_FPS)
        _one_of("frames", self.frames, FRAMES)
        _one_of("angles", self.angles, ANGLES)
        if self.modality is None:
            return
        _one_of("modality", self.modality, MODALITIES)
        for name, needed in (("version", "2.1"), ("frames", "videos")):
            given = getattr(self, name)
            if given != needed:
                raise DatasetError(
                    f"{name}: {given!r} given with modality {self.modality}; {needed!r} needed"
                )

    @property
    def additions(self) -> tuple[str, ...]:
        """Names of what is added."""
        return tuple(name for name in ADDITIONS if getattr(self, name))

    @property
    def encoder(self) -> str:
        return ENCODER if self.codec is None else self.codec


def _one_of(what: str, value: Any, allowed: tuple[str, ...]) -> None:
    if value not in allowed:
        raise DatasetError(f"{what}: {checks.short(value)} given; {', '.join(allowed)} allowed")
