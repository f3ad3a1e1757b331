"""Conversion to the formats whose options are the additions: HDF5 and RLDS."""

from __future__ import annotations

import abc
import contextlib
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any, ClassVar

from engram.datasets import additions, card, checks, source
from engram.datasets.collected import CollectedEpisodes, EpisodeSource
from engram.datasets.episodes import Episode, no_progress
from engram.datasets.folders import new_folder
from engram.datasets.frozen import FrozenCue
from engram.datasets.work import in_order


class Writer(contextlib.ExitStack):
    """A folder of a format that grows by episodes."""

    PLACE: ClassVar[tuple[str, ...]]  # below the root; {} stands for the task

    def __init__(self, path: Path, folder: EpisodeSource, added: Collection[str]):
        super().__init__()
        self.cue = self.enter_context(contextlib.closing(FrozenCue(folder.env_id, folder.origin)))
        self.path = path
        self.folder = folder
        self.added = added
        self.segments = additions.SegmentNames()

    @abc.abstractmethod
    def start(self) -> None:
        """Opens files, to be closed as an ExitStack does it."""

    @abc.abstractmethod
    def pack(self, episode: Episode) -> Any:
        """What is stored of an episode; called in threads."""

    @abc.abstractmethod
    def add(self, packed: Any) -> None: ...

    @abc.abstractmethod
    def finish(self) -> card.Card:
        """Stores what is known after the last episode."""

    @classmethod
    def convert(
        cls,
        folder: EpisodeSource,
        root: Path | str,
        jobs: int = 0,
        progress: Callable[[int, int], None] = no_progress,
        *,
        labels: bool = False,
        depth: bool = False,
        segmentation: bool = False,
        state: bool = False,
        objects: bool = False,
    ) -> Path:
        """Writes the folder of a task and returns its path.

        The folder appears when it is complete; one that was written here before is replaced. jobs:
        threads that pack, 0 for one per core; progress is called with the episodes done and all of
        them; labels: adds those of the demonstrations, which are privileged; depth, segmentation:
        add these images; state, objects: add these rows. Raises DatasetError, and leaves everything
        as it was, if an episode is damaged.
        """
        checks.whole_number("jobs", jobs, 0, checks.MAX_JOBS)
        added = additions.chosen(
            labels=labels, depth=depth, segmentation=segmentation, state=state, objects=objects
        )
        folder.require(added)
        instructions: set[str] = set()

        def packed(load: Callable[[], Episode]) -> tuple[Any, str, list[str] | None]:
            episode = load()
            return writer.pack(episode), episode.language_instruction, episode.segmentation_names

        place = cls._place(folder.env_id)
        with new_folder(root, *place) as path:
            with (
                cls(path, folder, added) as writer,
                in_order(packed, folder.loaders(), jobs) as episodes,
            ):
                writer.start()
                for done, (content, instruction, segments) in enumerate(episodes, 1):
                    writer.add(content)
                    instructions.add(instruction)
                    if additions.SEGMENTATION in added:
                        writer.segments.add(segments)
                    progress(done, len(folder))
                words = writer.finish()
            (path / "metadata.json").write_bytes(folder.metadata_bytes)
            (path / "README.md").write_text(card.text(folder, sorted(instructions), words), "utf-8")
            source.write(path, source.with_additions(folder, added))
        return Path(root).joinpath(*place)

    @classmethod
    def is_written(cls, folder: CollectedEpisodes, root: Path | str, **options: bool) -> bool:
        """True if the folder was written from the same collection; refuses another one."""
        return source.is_written(Path(root).joinpath(*cls._place(folder.env_id)), folder, **options)

    @classmethod
    def _place(cls, env_id: str) -> tuple[str, ...]:
        return tuple(part.format(env_id) for part in cls.PLACE)
