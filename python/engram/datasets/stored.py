"""An episode as a format stores it, with checks of its contents."""

from __future__ import annotations

import dataclasses
import io

import numpy as np

from engram.datasets import checks
from engram.datasets.checks import DatasetError
from engram.datasets.spaces import Spaces


@dataclasses.dataclass(frozen=True)
class StoredEpisode:
    """Exactly stored parts of an episode; None for parts that a format lacks."""

    spaces: Spaces
    seed: int
    action: np.ndarray  # (T, n)
    proprio: np.ndarray  # (T, 7 or 8)
    language_instruction: str
    rgb: np.ndarray | None = None  # (T, H, W, 6)
    reward: np.ndarray | None = None  # (T,)
    success: np.ndarray | None = None  # (T,)
    angles: str = "benchmark"  # the form of those in proprio

    def __post_init__(self) -> None:
        checks.whole_number("episode_seed", self.seed, 0, checks.MAX_SEED)
        checks.instruction("instruction", self.language_instruction)
        steps = checks.whole_number("steps", len(self.action), 1, checks.MAX_STEPS)
        for name, shape in (
            ("action", (steps, len(self.spaces.action_names))),
            ("proprio", (steps, len(self.spaces.proprio_names))),
            ("rgb", (steps, *checks.PICTURE_SHAPE)),
            ("reward", (steps,)),
            ("success", (steps,)),
        ):
            values = getattr(self, name)
            if values is not None and values.shape != shape:
                raise DatasetError(f"{name} has shape {values.shape}, {shape} expected")
        self.spaces.check_actions("action", self.action)


def pictures(encoded: list[bytes]) -> np.ndarray:
    """PNG files as (T, H, W, 3); their size is checked before they are unpacked."""
    from PIL import Image

    height, width, channels = checks.CAMERA_SHAPE
    pictures = np.empty((len(encoded), height, width, channels), np.uint8)
    for picture, data in zip(pictures, encoded):
        with Image.open(io.BytesIO(data), formats=["PNG"]) as image:
            if image.size != (width, height) or image.mode != "RGB":
                raise DatasetError(f"a picture of {image.size}, {image.mode}")
            picture[:] = image
    return pictures
