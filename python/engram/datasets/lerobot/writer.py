"""Writes demonstrations as a LeRobotDataset of either version."""

from __future__ import annotations

import contextlib
import dataclasses
import functools
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from engram.datasets import frame_stats, source
from engram.datasets.additions import MAPS, SegmentNames
from engram.datasets.collected import CollectedEpisodes, EpisodeSource
from engram.datasets.episodes import (
    LEROBOT_METADATA,
    Episode,
    no_progress,
)
from engram.datasets.folders import new_folder
from engram.datasets.frozen import COLUMN, FrozenCue
from engram.datasets.lerobot import (
    gr00t,
    label_columns,
    layout,
    map_columns,
    questions,
    readme,
    v21,
    v30,
)
from engram.datasets.lerobot.choice import smaller_frames
from engram.datasets.lerobot.videos import video_info
from engram.datasets.lerobot_options import Options
from engram.datasets.spaces import Spaces
from engram.datasets.work import ahead, in_order

_FILES: dict[str, type[v21.Files] | type[v30.Files]] = {"3.0": v30.Files, "2.1": v21.Files}


def convert(
    folder: EpisodeSource,
    root: Path | str,
    progress: Callable[[int, int], None] = no_progress,
    **options: Any,
) -> Path:
    """Writes <root>/data_lerobot/<id> and returns its path.

    The folder appears when it is complete; one that was written here before is replaced. options:
    those of ``Options``. progress is called with the episodes done and all of them. Raises
    DatasetError, and leaves everything as it was, if an episode is damaged or the encoder fails.
    """
    asked = chosen = Options(**options)
    folder.require(asked.additions)
    if asked.frames == "auto":
        chosen = dataclasses.replace(asked, frames=smaller_frames(folder, asked))
    place = (layout.FOLDER, folder.env_id)
    question = questions.question_of(folder.env_id) if chosen.labels else None
    with new_folder(root, *place) as path:
        with (
            contextlib.closing(FrozenCue(folder.env_id, folder.origin)) as cue,
            _Writer(path, folder.spaces, chosen, folder.keeps_failures, cue, question) as writer,
            ahead(folder, 2) as episodes,
        ):
            for done, episode in enumerate(episodes, 1):
                writer.add(episode)
                progress(done, len(folder))
        writer.write_meta()
        words = readme.text(folder, chosen, asked, list(writer.tasks), is_frozen=bool(cue))
        (path / "README.md").write_text(words, "utf-8")
        (path / LEROBOT_METADATA).write_bytes(folder.metadata_bytes)
        source.write(path, _source(folder, chosen), layout.SOURCE)
    return Path(root).joinpath(*place)


def _source(folder: EpisodeSource, options: Options) -> dict[str, Any]:
    return source.document(folder, dataclasses.asdict(options) | {"codec": options.encoder})


def is_written(folder: CollectedEpisodes, root: Path | str, **options: Any) -> bool:
    """True if the folder was written from the same collection; refuses another one."""
    path = Path(root) / layout.FOLDER / folder.env_id
    asked = Options(**options)
    frames = ("videos", "images") if asked.frames == "auto" else (asked.frames,)
    allowed = [_source(folder, dataclasses.replace(asked, frames=one)) for one in frames]
    return source.is_same(path, layout.SOURCE, *allowed)


class _Writer:
    """A data set that grows by episodes."""

    def __init__(
        self,
        root: Path,
        spaces: Spaces,
        options: Options,
        keeps_failures: bool,
        cue: FrozenCue,
        question: str | None,
    ):
        self.root = root
        self.cue = cue
        self.question = question
        self.keeps_failures = keeps_failures
        self.spaces = spaces
        self.options = options
        self.tasks: dict[str, int] = {}
        self.subtasks: dict[str, int] = {}
        self.segments = SegmentNames()
        self.label_features: dict[str, dict[str, Any]] = {}
        self.widths: dict[str, int] = {}  # of state or objects
        self.rows: list[dict[str, Any]] = []
        self.stats: list[dict[str, frame_stats.Stats]] = []  # of episodes
        self.all_stats: dict[str, frame_stats.Numbers | frame_stats.Levels] = {}  # by feature
        self.frames = 0
        self.files: v21.Files | v30.Files = _FILES[options.version](root, options)

    def __enter__(self) -> _Writer:
        return self

    def __exit__(self, kind: Any, *_: Any) -> None:
        # The first error is reported.
        with contextlib.suppress(Exception) if kind else contextlib.nullcontext():
            self.files.close()

    def add(self, episode: Episode) -> None:
        task = self.tasks.setdefault(episode.language_instruction, len(self.tasks))
        columns = self._columns(episode, task)
        images = dict(zip(layout.CAMERAS, (episode.image, episode.wrist_image)))
        row = {
            "episode_index": len(self.rows),
            "tasks": [episode.language_instruction],
            "length": len(episode),
            "episode_seed": episode.episode_seed,
        }
        if self.keeps_failures:
            row["episode_success"] = episode.success_once
        numbers = self._label_columns(episode)
        rows = episode.rows(self.options.additions)
        numbers |= {layout.ROWS[name]: values for name, values in rows.items()}
        self.widths = {layout.ROWS[name]: values.shape[1] for name, values in rows.items()}
        if self.cue:
            numbers[COLUMN] = self.cue.mask(episode)
        stored, filmed = ({}, images) if self.options.frames == "videos" else (images, {})
        maps = map_columns.columns(episode.maps(self.options.additions))
        if self.options.segmentation:
            self.segments.add(episode.segmentation_names)
        table = layout.table(columns | numbers, stored | maps)
        if self._has_language and episode.labels is not None:
            words = episode.language_instruction
            table = label_columns.with_language(table, episode.labels, words, self.question)
        if self.options.version == "2.1":  # whose readers refuse statistics of one channel
            maps = {}
        add = functools.partial(self.files.add, row | {"first_frame": self.frames}, table, filmed)
        count = functools.partial(self._stats, columns | numbers, images, maps)
        with in_order(lambda call: call(), (add, count)) as results:
            place, stats = results
        self.rows.append(row | place)
        self.stats.append(stats)
        self.frames += len(episode)

    def _stats(
        self,
        columns: dict[str, np.ndarray],
        images: dict[str, np.ndarray],
        maps: dict[str, np.ndarray],
    ) -> dict[str, frame_stats.Stats]:
        """Statistics of an episode, which those of the data set then include."""
        if not self.all_stats:
            self.all_stats |= {key: frame_stats.Numbers() for key in columns}
            self.all_stats |= {key: frame_stats.Levels(1 / 255) for key in images}
            self.all_stats |= {key: frame_stats.Levels() for key in maps}
        values = columns | images | maps
        return {key: self.all_stats[key].add(values[key]) for key in values}

    def _total_stats(self) -> dict[str, frame_stats.Stats]:
        """Statistics of the data set, with floors for state and action."""
        totals = {key: stats.total() for key, stats in self.all_stats.items()}
        for key in (layout.STATE, layout.ACTION):
            total = totals[key]
            totals[key] = frame_stats.floored(total)
            if self.options.version == "2.1":  # whose readers use those of episodes alone
                for episode in self.stats:
                    episode[key] = frame_stats.raised(episode[key], total, totals[key])
        return totals

    def _columns(self, episode: Episode, task: int) -> dict[str, np.ndarray]:
        steps = len(episode)
        frames = np.arange(steps)
        columns = {
            layout.STATE: self.spaces.proprio(episode.proprio, self.options.angles),
            layout.ACTION: episode.action,
            "timestamp": (frames / self.options.fps).astype(np.float32),
            "frame_index": frames,
            "episode_index": np.full(steps, len(self.rows)),
            "index": self.frames + frames,
            "task_index": np.full(steps, task),
        }
        if self.options.modality:
            columns[gr00t.ANNOTATION] = columns["task_index"]
        return columns

    @property
    def _has_language(self) -> bool:
        return self.options.labels and self.options.version != "2.1"  # whose readers know none

    def _label_columns(self, episode: Episode) -> dict[str, np.ndarray]:
        if not self.options.labels or episode.labels is None:
            return {}
        numbers = label_columns.numbers(episode.labels, self.subtasks)
        self.label_features = label_columns.features(list(numbers))
        if self._has_language:
            self.label_features |= label_columns.language_features()
        return numbers

    def write_meta(self) -> None:
        meta = self.root / "meta"
        meta.mkdir(exist_ok=True)
        totals = self._total_stats()
        self.files.write_meta(list(self.tasks), self.rows, self.stats)
        layout.write_json(meta / "stats.json", frame_stats.as_lists(totals))
        layout.write_json(meta / "info.json", self._info())
        if self.subtasks:
            layout.write_names(meta / "subtasks.parquet", label_columns.SUBTASK, self.subtasks)
        if self.options.modality:
            layout.write_json(meta / "modality.json", gr00t.modality(self.spaces))

    def _info(self) -> dict[str, Any]:
        infos = {}
        if self.options.frames == "videos":
            infos = {
                key: video_info(self.files.video_path(key), self.options.fps, self.options.encoder)
                for key in layout.CAMERAS
            }
        maps = [name for name in MAPS if name in self.options.additions]
        features = layout.features(self.spaces, infos)
        features |= map_columns.features(maps, self.segments.names) | self.label_features
        for key, width in self.widths.items():
            features[key] = {"dtype": "float32", "shape": [width], "names": None}
        if self.cue:
            features[COLUMN] = {"dtype": "bool", "shape": [1], "names": None}
        if self.options.modality:
            features[gr00t.ANNOTATION] = {"dtype": "int64", "shape": [1], "names": None}
        return {
            "codebase_version": f"v{self.options.version}",
            "robot_type": layout.ROBOT_TYPE,
            "total_episodes": len(self.rows),
            "total_frames": self.frames,
            "total_tasks": len(self.tasks),
            "chunks_size": layout.FILES_PER_CHUNK,
            "fps": self.options.fps,
            "splits": {"train": f"0:{len(self.rows)}"},
            **self.files.info(len(self.rows)),
            "features": features,
        }
