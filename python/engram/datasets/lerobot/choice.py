"""Choice between videos and images by their size."""

from __future__ import annotations

import contextlib
import io

from engram.datasets.collected import EpisodeSource
from engram.datasets.episodes import Episode
from engram.datasets.lerobot import layout
from engram.datasets.lerobot.videos import VideoFile
from engram.datasets.lerobot_options import Options

_EPISODES = 3  # that are encoded both ways


def smaller_frames(folder: EpisodeSource, options: Options) -> str:
    """What takes up less of the first episodes: "videos", or "images", which win a draw."""
    images = videos = 0
    for episode in folder[:_EPISODES]:
        images += _bytes_of_images(episode)
        videos += _bytes_of_videos(episode, options)
    return "images" if images <= videos else "videos"


def _bytes_of_images(episode: Episode) -> int:
    table = layout.table({}, dict(zip(layout.CAMERAS, (episode.image, episode.wrist_image))))
    file = io.BytesIO()
    with layout.parquet_writer(file, table.schema) as writer:
        writer.write_table(table)
    return file.tell()


def _bytes_of_videos(episode: Episode, options: Options) -> int:
    total = 0
    for images in (episode.image, episode.wrist_image):
        size = (images.shape[1], images.shape[2])
        video = VideoFile(io.BytesIO(), size, options.fps, options.encoder)
        with contextlib.closing(video):
            video.add(images)
        total += video.bytes
    return total
