"""Depth and segmentation as images of a LeRobotDataset: 16 bits a pixel, lossless.

LeRobot 0.6 reads both as float32 (1, height, width) in the stored unit, and depth in metres by
`depth_output_unit="m"`.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np

from engram.datasets.additions import DEPTH, MAP_SHAPE
from engram.datasets.lerobot import layout


def key(camera: str, name: str) -> str:
    """The feature of a camera's depth or segmentation."""
    return f"{camera}_{name}"


def columns(maps: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Images (T, H, W) by feature, of those (T, H, W, 2)."""
    return {
        key(camera, name): values[..., index]
        for name, values in maps.items()
        for index, camera in enumerate(layout.CAMERAS)
    }


def features(names: Collection[str], segments: list[str] | None) -> dict[str, dict[str, Any]]:
    """Entries of info.json."""
    return {
        key(camera, name): {
            "dtype": "image",
            "shape": list(MAP_SHAPE),
            "names": ["height", "width", "channel"],
            "info": {"is_depth_map": True, "depth_unit": "mm"}
            if name == DEPTH
            else {"is_depth_map": False, "segmentation_names": segments},
        }
        for name in names
        for camera in layout.CAMERAS
    }
