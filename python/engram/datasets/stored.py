"""An episode as a format stores it, with checks of its contents."""

from __future__ import annotations

import dataclasses
import io

import numpy as np

from engram.datasets import checks
from engram.datasets.additions import DEPTH, MAP_TYPE, MAPS_SHAPE, ROWS, SEGMENTATION
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
    depth: np.ndarray | None = None  # (T, H, W, 2)
    segmentation: np.ndarray | None = None  # (T, H, W, 2)
    state: np.ndarray | None = None  # (T, n), as the next
    objects: np.ndarray | None = None
    angles: str = "benchmark"  # the form of those in proprio

    def __post_init__(self) -> None:
        checks.whole_number("episode_seed", self.seed, 0, checks.MAX_SEED)
        checks.instruction("instruction", self.language_instruction)
        steps = checks.whole_number("steps", len(self.action), 1, checks.MAX_STEPS)
        for name, shape in (
            ("action", (steps, len(self.spaces.action_names))),
            ("proprio", (steps, len(self.spaces.proprio_names))),
            ("rgb", (steps, *checks.IMAGE_SHAPE)),
            ("reward", (steps,)),
            ("success", (steps,)),
            (DEPTH, (steps, *MAPS_SHAPE)),
            (SEGMENTATION, (steps, *MAPS_SHAPE)),
        ):
            values = getattr(self, name)
            if values is not None and values.shape != shape:
                raise DatasetError(f"{name} has shape {values.shape}, {shape} expected")
        for name, rows in self.rows().items():
            if rows.ndim != 2 or len(rows) != steps:
                raise DatasetError(f"{name} has shape {rows.shape}, {steps} rows expected")
        self.spaces.check_actions("action", self.action)

    def rows(self) -> dict[str, np.ndarray]:
        """State or objects, where they are stored."""
        found = {name: getattr(self, name) for name in ROWS}
        return {name: values for name, values in found.items() if values is not None}


def images(encoded: list[bytes]) -> np.ndarray:
    """PNG files as (T, H, W, 3); their size is checked before they are unpacked."""
    return _unpacked(encoded, checks.CAMERA_SHAPE, np.uint8, ("RGB",))


def maps(encoded: list[bytes]) -> np.ndarray:
    """PNG files of 16 bits, of depth or segmentation, as (T, H, W)."""
    # Older versions of Pillow give them as 32 bits.
    return _unpacked(encoded, MAPS_SHAPE[:2], MAP_TYPE, ("I;16", "I"))


def _unpacked(
    encoded: list[bytes], shape: tuple[int, ...], kind: type, modes: tuple[str, ...]
) -> np.ndarray:
    from PIL import Image

    images: np.ndarray = np.empty((len(encoded), *shape), kind)
    for image, data in zip(images, encoded):
        with Image.open(io.BytesIO(data), formats=["PNG"]) as file:
            if file.size != (shape[1], shape[0]) or file.mode not in modes:
                raise DatasetError(f"an image of {file.size}, {file.mode}")
            image[:] = file
    return images
