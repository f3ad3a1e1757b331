"""Writes demonstrations as a LeRobotDataset, version 3.0 or 2.1: parquet, MP4 and meta files.

Videos are lossy; everything else, and images with ``frames="images"``, is stored exactly.
"""

from __future__ import annotations

from engram.datasets.lerobot.writer import convert, is_written
from engram.datasets.lerobot_options import Options

__all__ = ["Options", "convert", "is_written"]
