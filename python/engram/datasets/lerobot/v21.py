"""Files of LeRobotDataset v2.1: one parquet file per episode, one video per episode and camera."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from engram.datasets import frame_stats
from engram.datasets.lerobot import layout
from engram.datasets.lerobot.videos import VideoFile
from engram.datasets.lerobot_options import Options
from engram.datasets.work import in_order

_EPISODE = "episode_{episode_index:06d}"
DATA_PATH = f"data/chunk-{{episode_chunk:03d}}/{_EPISODE}.parquet"
_VIDEO_PATH = f"videos/chunk-{{episode_chunk:03d}}/{{video_key}}/{_EPISODE}.mp4"
EPISODES = "meta/episodes.jsonl"


def data_path(episode: int) -> str:
    """The file of an episode, within the data set."""
    return DATA_PATH.format(episode_chunk=episode // layout.FILES_PER_CHUNK, episode_index=episode)


class Files:
    """The files of a data set that grows by episodes."""

    def __init__(self, root: Path, options: Options):
        self.root = root
        self.options = options
        self.cameras = 0

    def add(
        self, row: dict[str, Any], table: pa.Table, videos: dict[str, np.ndarray]
    ) -> dict[str, Any]:
        """Writes an episode; its row need not say where it is."""
        number = row["episode_index"]
        path = self.root / data_path(number)
        path.parent.mkdir(parents=True, exist_ok=True)
        with open(path, "wb") as file, layout.parquet_writer(file, table.schema) as writer:
            writer.write_table(table)
        self.cameras = len(videos)

        def film(camera: tuple[str, np.ndarray]) -> None:
            key, images = camera
            size = (images.shape[1], images.shape[2])
            path = self.video_path(key, number)
            video = VideoFile(path, size, self.options.fps, self.options.encoder)
            with contextlib.closing(video):
                video.add(images)

        with in_order(film, videos.items()) as filmed:
            for _ in filmed:
                pass
        return {}

    def close(self) -> None:
        """Does nothing: every episode's files are closed."""

    def video_path(self, key: str, episode: int = 0) -> Path:
        """The file of a camera."""
        chunk = episode // layout.FILES_PER_CHUNK
        name = _VIDEO_PATH.format(video_key=key, episode_chunk=chunk, episode_index=episode)
        return self.root / name

    def write_meta(self, tasks: list[str], rows: list[dict], stats: list[dict]) -> None:
        meta = self.root / "meta"
        numbered = [{"task_index": i, "task": task} for i, task in enumerate(tasks)]
        _write_lines(meta / "tasks.jsonl", numbered)
        _write_lines(self.root / EPISODES, rows)
        rows_of_stats = [
            {"episode_index": i, "stats": frame_stats.as_lists(one)} for i, one in enumerate(stats)
        ]
        _write_lines(meta / "episodes_stats.jsonl", rows_of_stats)

    def info(self, episodes: int) -> dict[str, Any]:
        """Fields of info.json that only this version has."""
        return {
            "total_videos": episodes * self.cameras,
            "total_chunks": -(-episodes // layout.FILES_PER_CHUNK),
            "data_path": DATA_PATH,
            "video_path": _VIDEO_PATH if self.cameras else None,
        }


def _write_lines(path: Path, rows: list[dict]) -> None:
    path.write_text("".join(json.dumps(row) + "\n" for row in rows), "utf-8")
