"""Reads the episodes of a LeRobotDataset that was written here, of either version."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq

from engram.datasets import checks, source
from engram.datasets.additions import MAPS
from engram.datasets.checks import DatasetError, reading
from engram.datasets.episodes import Metadata
from engram.datasets.lerobot import layout, map_columns, v21, v30
from engram.datasets.spaces import ANGLES, Spaces
from engram.datasets.stored import StoredEpisode, images, maps

_MOST_ROWS = 10_000_000  # of a file
_LARGEST_EPISODES = 1 << 30  # bytes


def read(folder: Metadata, root: Path) -> Iterator[StoredEpisode]:
    """The episodes of <root>/data_lerobot/<id>, in order."""
    path = root / layout.FOLDER / folder.env_id
    angles = _angles(path, folder.spaces)
    data: dict[Path, _Rows] = {}  # the file that the last episode was in
    for listing, row, place in _listed(path):
        with reading(listing):
            index = checks.whole_number(
                "episode_index", row["episode_index"], 0, checks.MAX_EPISODES
            )
        file = path / place
        with reading(file):
            if file not in data:
                data = {file: _Rows(pq.ParquetFile(checks.regular_file(file)))}
            yield _episode(data[file].of_episode(index), row, folder.spaces, angles)


def _angles(path: Path, spaces: Spaces) -> str:
    """The form of angles."""
    document = source.verify(path, layout.SOURCE)
    with reading(path / layout.SOURCE):
        found = Spaces(document["control_mode"], document["joint_proprio"])
        if found != spaces:
            raise DatasetError(f"a set of {found}, and its demonstrations are of {spaces}")
        angles: str = document["options"]["angles"]
        if angles not in ANGLES:
            raise DatasetError(f"angles: {checks.short(angles)} given; {', '.join(ANGLES)} allowed")
        return angles


# --- lists of episodes ---


def _listed(path: Path) -> Iterator[tuple[Path, dict[str, Any], str]]:
    """The list's file, the row and the data file of every episode."""
    lines = path / v21.EPISODES
    if lines.exists():
        with reading(lines):
            text = checks.regular_file(lines, _LARGEST_EPISODES).read_text("utf-8")
            rows = [json.loads(line) for line in text.splitlines()]
        for row in rows:
            with reading(lines):
                index = _number(row, "episode_index")
            yield lines, row, v21.data_path(index)
        return
    files = sorted(path.glob("meta/episodes/*/*.parquet"))
    if not files:
        raise DatasetError(f"'{path}' holds no episodes")
    for file in files:
        with reading(file):
            parquet = pq.ParquetFile(checks.regular_file(file))
            checks.whole_number("rows", parquet.metadata.num_rows, 0, checks.MAX_EPISODES)
            rows = parquet.read(use_threads=False).to_pylist()
        for row in rows:
            with reading(file):
                numbers = {
                    key: _number(row, f"data/{key}") for key in ("chunk_index", "file_index")
                }
            yield file, row, v30.DATA_PATH.format(**numbers)


def _number(row: dict[str, Any], name: str) -> int:
    return checks.whole_number(name, row[name], 0, checks.MAX_EPISODES)


# --- data ---


class _Rows:
    """A file of LeRobot's, from which episodes are read one by one.

    Without pyarrow's scanner of data sets, which never returns for some damaged files.
    """

    def __init__(self, file: Any):
        checks.whole_number("rows", file.metadata.num_rows, 0, _MOST_ROWS)
        self.file = file
        groups = range(file.metadata.num_row_groups)
        self.ends = np.cumsum([file.metadata.row_group(group).num_rows for group in groups])
        column = file.read(columns=["episode_index"], use_threads=False).column(0)
        self.episodes = column.to_numpy()

    def of_episode(self, index: int) -> Any:
        """The rows of one episode, which lie side by side."""
        rows = np.flatnonzero(self.episodes == index)
        checks.whole_number("steps", len(rows), 1, checks.MAX_STEPS)
        first, last = np.searchsorted(self.ends, [rows[0], rows[-1]], side="right")
        table = self.file.read_row_groups(range(first, last + 1), use_threads=False)
        begin = self.ends[first - 1] if first > 0 else 0
        return table.slice(rows[0] - begin, rows[-1] + 1 - rows[0])


def _episode(table: Any, row: dict[str, Any], spaces: Spaces, angles: str) -> StoredEpisode:
    columns = table.to_pydict()
    rgb = None
    if layout.TOP in columns:  # stored as images, not as lossy videos
        cameras = [[one["bytes"] for one in columns[key]] for key in layout.CAMERAS]
        rgb = np.concatenate([images(files) for files in cameras], axis=-1)
    names = [name for name in MAPS if map_columns.key(layout.TOP, name) in columns]
    found = {
        name: np.stack(
            [
                maps([one["bytes"] for one in columns[map_columns.key(camera, name)]])
                for camera in layout.CAMERAS
            ],
            axis=-1,
        )
        for name in names
    }
    for name, key in layout.ROWS.items():
        if key in columns:
            found[name] = np.array(columns[key], np.float32)
    return StoredEpisode(
        spaces,
        row["episode_seed"],
        np.array(columns[layout.ACTION], np.float32),
        np.array(columns[layout.STATE], np.float32),
        row["tasks"][0],
        rgb,
        angles=angles,
        **found,
    )
