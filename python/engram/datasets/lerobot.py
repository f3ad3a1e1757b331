"""Writes demonstrations as a LeRobotDataset v3: parquet, MP4 and meta files.

Episodes follow one another in few large files. Videos are lossy; everything else, and images with
`videos=False`, is stored exactly.
"""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any, BinaryIO

import av
import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from engram.datasets import checks, frame_stats
from engram.datasets.checks import DatasetError
from engram.datasets.episodes import DemonstrationFolder, Episode, no_progress
from engram.datasets.folders import new_folder
from engram.datasets.work import png

FPS = 10  # nominal, as in the published data; the robot is controlled at 20 Hz
ROBOT_TYPE = "mikasa_robo"
CODEC = "libsvtav1"

TOP = "observation.images.top"
WRIST = "observation.images.wrist"
CAMERAS = (TOP, WRIST)

_FILE = "chunk-{chunk_index:03d}/file-{file_index:03d}"
DATA_PATH = f"data/{_FILE}.parquet"
_VIDEO_PATH = f"videos/{{video_key}}/{_FILE}.mp4"
_EPISODES_PATH = f"meta/episodes/{_FILE}.parquet"
_FILES_PER_CHUNK = 1000
_DATA_FILE_MB = 100
_VIDEO_FILE_MB = 200

_NAMES = {
    "observation.state": ["x", "y", "z", "roll", "pitch", "yaw", "gripper"],
    "action": [
        "delta_x",
        "delta_y",
        "delta_z",
        "rotation_x",
        "rotation_y",
        "rotation_z",
        "gripper",
    ],
}
_COUNTERS = ("timestamp", "frame_index", "episode_index", "index", "task_index")


def convert(
    folder: DemonstrationFolder,
    root: Path | str,
    fps: int = FPS,
    videos: bool = True,
    codec: str = CODEC,
    progress: Callable[[int, int], None] = no_progress,
) -> Path:
    """Writes <root>/data_lerobot/<id> and returns its path.

    The folder appears when it is complete; one that was written here before is replaced. videos:
    False stores every frame as PNG instead. codec: an encoder of FFmpeg. progress is called with
    the episodes done and all of them. Raises DatasetError, and leaves everything as it was, if an
    episode is damaged or the encoder fails.
    """
    checks.whole_number("fps", fps, 1, checks.MAX_FPS)
    place = ("data_lerobot", folder.env_id)
    with new_folder(root, *place) as path:
        with _Writer(path, fps, videos, codec) as writer:
            for done, episode in enumerate(folder, 1):
                writer.add(episode)
                progress(done, len(folder))
        writer.write_meta()
        (path / "source_rlds_metadata.json").write_bytes(folder.metadata_bytes)
    return Path(root).joinpath(*place)


class _Writer:
    """A data set that grows by episodes."""

    def __init__(self, root: Path, fps: int, videos: bool, codec: str):
        self.root = root
        self.fps = fps
        self.tasks: dict[str, int] = {}
        self.episodes: list[dict] = []
        self.stats: list[dict] = []
        self.frames = 0
        self.data = _ParquetFiles(root)
        self.videos = {key: _VideoFiles(root, key, fps, codec) for key in CAMERAS} if videos else {}

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        # The first error is reported.
        with contextlib.suppress(Exception) if kind else contextlib.nullcontext():
            self.data.close()
            for video in self.videos.values():
                video.close()

    def add(self, episode: Episode) -> None:
        steps = len(episode)
        index = len(self.episodes)
        task = self.tasks.setdefault(episode.language_instruction, len(self.tasks))
        frames = np.arange(steps)
        columns = {
            "observation.state": episode.proprio,
            "action": episode.action,
            "timestamp": (frames / self.fps).astype(np.float32),
            "frame_index": frames,
            "episode_index": np.full(steps, index),
            "index": self.frames + frames,
            "task_index": np.full(steps, task),
        }
        images = dict(zip(CAMERAS, (episode.image, episode.wrist_image)))
        row = {
            "episode_index": index,
            "tasks": [episode.language_instruction],
            "length": steps,
            "dataset_from_index": self.frames,
            "dataset_to_index": self.frames + steps,
            "meta/episodes/chunk_index": 0,
            "meta/episodes/file_index": 0,
            "episode_seed": episode.episode_seed,
        }
        row |= self.data.add(columns, {} if self.videos else images)
        for key, video in self.videos.items():
            row |= video.add(images[key])
        stats = {key: frame_stats.of_values(values) for key, values in columns.items()}
        stats |= {key: frame_stats.of_images(values) for key, values in images.items()}
        self.stats.append(stats)
        self.episodes.append(row)
        self.frames += steps

    def write_meta(self) -> None:
        meta = self.root / "meta"
        meta.mkdir(exist_ok=True)
        pd.DataFrame({"task_index": list(self.tasks.values())}, index=list(self.tasks)).to_parquet(
            meta / "tasks.parquet"
        )
        rows = [
            row | frame_stats.flat("stats", stats) for row, stats in zip(self.episodes, self.stats)
        ]
        path = self.root / _EPISODES_PATH.format(chunk_index=0, file_index=0)
        path.parent.mkdir(parents=True)
        pq.write_table(pa.Table.from_pylist(rows), path)
        _write_json(meta / "stats.json", frame_stats.combined(self.stats))
        _write_json(meta / "info.json", self._info())

    def _info(self) -> dict:
        return {
            "codebase_version": "v3.0",
            "robot_type": ROBOT_TYPE,
            "total_episodes": len(self.episodes),
            "total_frames": self.frames,
            "total_tasks": len(self.tasks),
            "chunks_size": _FILES_PER_CHUNK,
            "data_files_size_in_mb": _DATA_FILE_MB,
            "video_files_size_in_mb": _VIDEO_FILE_MB,
            "fps": self.fps,
            "splits": {"train": f"0:{len(self.episodes)}"},
            "data_path": DATA_PATH,
            "video_path": _VIDEO_PATH if self.videos else None,
            "features": self._features(),
        }

    def _features(self) -> dict:
        features: dict[str, dict[str, Any]] = {}
        for key in CAMERAS:
            features[key] = {
                "dtype": "video" if self.videos else "image",
                "shape": list(checks.CAMERA_SHAPE),
                "names": ["height", "width", "channel"],
            }
            if self.videos:
                features[key]["info"] = self.videos[key].info()
        for key, names in _NAMES.items():
            features[key] = {"dtype": "float32", "shape": [len(names)], "names": names}
        for key in _COUNTERS:
            dtype = "float32" if key == "timestamp" else "int64"
            features[key] = {"dtype": dtype, "shape": [1], "names": None}
        return features


class _FileNumbers:
    """Numbers of files, so many to a chunk."""

    def __init__(self):
        self.number = 0

    def as_dict(self) -> dict[str, int]:
        return {
            "chunk_index": self.number // _FILES_PER_CHUNK,
            "file_index": self.number % _FILES_PER_CHUNK,
        }


class _ParquetFiles:
    """Frames as rows; one row group per episode."""

    def __init__(self, root: Path):
        self.root = root
        self.numbers = _FileNumbers()
        self.writer: pq.ParquetWriter | None = None
        self.file: BinaryIO | None = None

    def add(self, columns: dict[str, np.ndarray], images: dict[str, np.ndarray]) -> dict[str, int]:
        """Appends an episode; returns where it is."""
        arrays = {key: _arrow(values) for key, values in columns.items()}
        for key, frames in images.items():
            arrays[key] = pa.array(
                [{"bytes": png(frame), "path": None} for frame in frames],
                pa.struct({"bytes": pa.binary(), "path": pa.string()}),
            )
        table = pa.table(arrays)
        if self.file is not None and self.file.tell() >= _DATA_FILE_MB << 20:
            self.close()
            self.numbers.number += 1
        if self.writer is None:
            path = self.root / DATA_PATH.format(**self.numbers.as_dict())
            path.parent.mkdir(parents=True, exist_ok=True)
            self.file = open(path, "wb")  # noqa: SIM115 (closed by close)
            self.writer = pq.ParquetWriter(self.file, table.schema)
        self.writer.write_table(table)
        return {f"data/{key}": value for key, value in self.numbers.as_dict().items()}

    def close(self) -> None:
        if self.writer is not None and self.file is not None:
            self.writer.close()
            self.file.close()
            self.writer = self.file = None


class _VideoFiles:
    """The frames of one camera; episodes follow one another without gaps in time."""

    def __init__(self, root: Path, key: str, fps: int, codec: str):
        self.root = root
        self.key = key
        self.fps = fps
        self.codec = codec
        self.numbers = _FileNumbers()
        self.container: Any = None
        self.stream: Any = None
        self.frames = 0  # in the present file
        self.bytes = 0

    def path(self) -> Path:
        return self.root / _VIDEO_PATH.format(video_key=self.key, **self.numbers.as_dict())

    def add(self, images: np.ndarray) -> dict:
        """Appends an episode; returns where it is."""
        if self.bytes >= _VIDEO_FILE_MB << 20:
            self.close()
            self.numbers.number += 1
        begin = self.frames
        with _encoding(self.codec):
            if self.container is None:
                self._open(images.shape[1:3])
            for image in images:
                frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(image), format="rgb24")
                frame.pts = self.frames
                frame.time_base = Fraction(1, self.fps)
                self._mux(self.stream.encode(frame))
                self.frames += 1
        place = self.numbers.as_dict() | {
            "from_timestamp": begin / self.fps,
            "to_timestamp": self.frames / self.fps,
        }
        return {f"videos/{self.key}/{name}": value for name, value in place.items()}

    def info(self) -> dict:
        """Properties of the first file, for info.json."""
        first = self.root / _VIDEO_PATH.format(video_key=self.key, chunk_index=0, file_index=0)
        with _encoding(self.codec), av.open(str(first)) as container:
            stream = container.streams.video[0]
            return {
                "video.height": stream.height,
                "video.width": stream.width,
                "video.codec": stream.codec.canonical_name,
                "video.pix_fmt": stream.pix_fmt,
                "video.is_depth_map": False,
                "video.fps": self.fps,
                "video.channels": 3,
                "has_audio": False,
            }

    def close(self) -> None:
        if self.container is not None:
            container, self.container = self.container, None  # closed once, even if that fails
            with _encoding(self.codec), container:
                self._mux(self.stream.encode(), container)
            self.frames = 0
            self.bytes = 0

    def _open(self, size: tuple[int, int]) -> None:
        self.path().parent.mkdir(parents=True, exist_ok=True)
        self.container = av.open(str(self.path()), "w")
        # A key frame at every other frame, so that any frame is found quickly.
        options = {"g": "2", "crf": "30"}
        if self.codec == "libsvtav1":
            options["preset"] = "12"
            os.environ.setdefault("SVT_LOG", "1")  # errors only
        self.stream = self.container.add_stream(self.codec, rate=self.fps, options=options)
        self.stream.pix_fmt = "yuv420p"
        self.stream.height, self.stream.width = size

    def _mux(self, packets, container=None) -> None:
        for packet in packets:
            self.bytes += packet.size
            (container or self.container).mux(packet)


@contextlib.contextmanager
def _encoding(codec: str) -> Iterator[None]:
    """Tells what FFmpeg refuses: an encoder that it lacks, or that takes no such pictures."""
    try:
        yield
    except (av.FFmpegError, ValueError, TypeError, AttributeError) as error:
        raise DatasetError(f"codec: {codec!r} given; FFmpeg says: {error}") from error


def _arrow(values: np.ndarray) -> pa.Array:
    if values.ndim == 1:
        return pa.array(values)
    return pa.FixedSizeListArray.from_arrays(pa.array(values.ravel()), values.shape[1])


def _write_json(path: Path, document: dict) -> None:
    path.write_text(json.dumps(document, indent=4) + "\n")
