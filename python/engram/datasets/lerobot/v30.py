"""Files of LeRobotDataset v3.0: episodes follow one another in few large files."""

from __future__ import annotations

from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from engram.datasets import frame_stats
from engram.datasets.lerobot import layout
from engram.datasets.lerobot.videos import VideoFile
from engram.datasets.lerobot_options import Options
from engram.datasets.work import in_order

_FILE = "chunk-{chunk_index:03d}/file-{file_index:03d}"
DATA_PATH = f"data/{_FILE}.parquet"
_VIDEO_PATH = f"videos/{{video_key}}/{_FILE}.mp4"
_EPISODES_PATH = f"meta/episodes/{_FILE}.parquet"
_DATA_FILE_MB = 100
_VIDEO_FILE_MB = 200


class Files:
    """The files of a data set that grows by episodes."""

    def __init__(self, root: Path, options: Options):
        self.root = root
        self.options = options
        self.data = _ParquetFiles(root)
        self.videos: dict[str, _VideoFiles] = {}

    def add(
        self, row: dict[str, Any], table: pa.Table, videos: dict[str, np.ndarray]
    ) -> dict[str, Any]:
        """Appends an episode; returns what its row says about where it is."""
        place = {
            "dataset_from_index": row["first_frame"],
            "dataset_to_index": row["first_frame"] + row["length"],
            "meta/episodes/chunk_index": 0,
            "meta/episodes/file_index": 0,
        }
        place |= self.data.add(table)
        for key in videos:
            if key not in self.videos:
                self.videos[key] = _VideoFiles(self.root, key, self.options)
        with in_order(lambda one: self.videos[one[0]].add(one[1]), videos.items()) as places:
            for found in places:
                place |= found
        return place

    def close(self) -> None:
        self.data.close()
        for video in self.videos.values():
            video.close()

    def video_path(self, key: str) -> Path:
        """The first file of a camera."""
        return self.root / _VIDEO_PATH.format(video_key=key, chunk_index=0, file_index=0)

    def write_meta(self, tasks: list[str], rows: list[dict], stats: list[dict]) -> None:
        meta = self.root / "meta"
        layout.write_names(meta / "tasks.parquet", "task_index", tasks)
        flat = [row | frame_stats.flat("stats", one) for row, one in zip(rows, stats)]
        path = self.root / _EPISODES_PATH.format(chunk_index=0, file_index=0)
        path.parent.mkdir(parents=True)
        pq.write_table(pa.Table.from_pylist(flat), path)

    def info(self, episodes: int) -> dict[str, Any]:
        """Fields of info.json that only this version has."""
        return {
            "data_files_size_in_mb": _DATA_FILE_MB,
            "video_files_size_in_mb": _VIDEO_FILE_MB,
            "data_path": DATA_PATH,
            "video_path": _VIDEO_PATH if self.videos else None,
        }


class _FileNumbers:
    """Numbers of files, CHUNK to a chunk."""

    def __init__(self) -> None:
        self.number = 0

    def as_dict(self) -> dict[str, int]:
        return {
            "chunk_index": self.number // layout.FILES_PER_CHUNK,
            "file_index": self.number % layout.FILES_PER_CHUNK,
        }


class _ParquetFiles:
    """Frames as rows; one row group per episode."""

    def __init__(self, root: Path):
        self.root = root
        self.numbers = _FileNumbers()
        self.writer: pq.ParquetWriter | None = None
        self.file: BinaryIO | None = None

    def add(self, table: pa.Table) -> dict[str, int]:
        """Appends an episode; returns where it is."""
        if self.file is not None and self.file.tell() >= _DATA_FILE_MB << 20:
            self.close()
            self.numbers.number += 1
        if self.writer is None:
            path = self.root / DATA_PATH.format(**self.numbers.as_dict())
            path.parent.mkdir(parents=True, exist_ok=True)
            self.file = open(path, "wb")  # noqa: SIM115 (closed by close)
            self.writer = layout.parquet_writer(self.file, table.schema)
        self.writer.write_table(table)
        return {f"data/{key}": value for key, value in self.numbers.as_dict().items()}

    def close(self) -> None:
        if self.writer is not None and self.file is not None:
            self.writer.close()
            self.file.close()
            self.writer = self.file = None


class _VideoFiles:
    """The frames of one camera; episodes follow one another without gaps in time."""

    def __init__(self, root: Path, key: str, options: Options):
        self.root = root
        self.key = key
        self.options = options
        self.numbers = _FileNumbers()
        self.file: VideoFile | None = None

    def add(self, images: np.ndarray) -> dict[str, Any]:
        """Appends an episode; returns where it is."""
        if self.file is not None and self.file.bytes >= _VIDEO_FILE_MB << 20:
            self.close()
            self.numbers.number += 1
        if self.file is None:
            path = self.root / _VIDEO_PATH.format(video_key=self.key, **self.numbers.as_dict())
            size = (images.shape[1], images.shape[2])
            self.file = VideoFile(path, size, self.options.fps, self.options.encoder)
        begin = self.file.frames
        self.file.add(images)
        place = self.numbers.as_dict() | {
            "from_timestamp": begin / self.options.fps,
            "to_timestamp": self.file.frames / self.options.fps,
        }
        return {f"videos/{self.key}/{name}": value for name, value in place.items()}

    def close(self) -> None:
        if self.file is not None:
            file, self.file = self.file, None
            file.close()
