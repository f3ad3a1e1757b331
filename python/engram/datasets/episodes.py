"""Reads what `engram collect` wrote: one .npz file per episode, and metadata.json.

Data sets are external input. Everything is checked before it is used: names before they are paths,
sizes before memory is allocated, values before they are written.
"""

from __future__ import annotations

import dataclasses
import functools
import json
import zipfile
from collections.abc import Callable, Collection, Iterator, Sequence
from pathlib import Path
from typing import IO, Any, TypeVar

import numpy as np

import engram
from engram._io import documents
from engram.datasets import additions, checks, labels
from engram.datasets.checks import DatasetError, reading
from engram.datasets.labels import Labels
from engram.datasets.npz_arrays import ANY, read_array
from engram.datasets.spaces import Spaces

_LARGEST_METADATA = 256 << 20  # bytes
BENCHMARK = Spaces()


@dataclasses.dataclass(frozen=True)
class Episode:
    """One demonstration of T steps, from the first observation to the first success, or its end."""

    rgb: np.ndarray  # (T, H, W, 6) uint8: base camera, wrist camera; before the action
    proprio: np.ndarray  # (T, 7 or 8) float32; before the action
    action: np.ndarray  # (T, n) float32, n by the control mode
    reward: np.ndarray  # (T,) float32; after the action
    success: np.ndarray  # (T,) int32; after the action
    done: np.ndarray  # (T,) int32; after the action
    language_instruction: str
    success_once: bool
    episode_length: int
    episode_seed: int
    # Additions, of folders that have them:
    labels: Labels | None = None
    depth: np.ndarray | None = None  # (T, H, W, 2) uint16: mm, of both cameras
    segmentation: np.ndarray | None = None  # the same: indices into segmentation_names
    segmentation_names: list[str] | None = None
    state: np.ndarray | None = (
        None  # (T, n) float32: the row of the mode "state"; before the action
    )
    objects: np.ndarray | None = None  # (T, n) float32: that of "objects"

    def __len__(self) -> int:
        return self.episode_length

    @property
    def image(self) -> np.ndarray:
        """The base camera, (T, H, W, 3)."""
        return self.rgb[..., :3]

    @property
    def wrist_image(self) -> np.ndarray:
        """The wrist camera, (T, H, W, 3)."""
        return self.rgb[..., 3:]

    def maps(self, names: Collection[str]) -> dict[str, np.ndarray]:
        """Depth and segmentation, those that are among the names."""
        return {name: getattr(self, name) for name in additions.MAPS if name in names}

    def rows(self, names: Collection[str]) -> dict[str, np.ndarray]:
        """State or objects, where they are among the names."""
        return {name: getattr(self, name) for name in additions.ROWS if name in names}

    @classmethod
    def load(
        cls,
        path: Path | str | IO[bytes],
        spaces: Spaces = BENCHMARK,
        present: Collection[str] = (),
    ) -> Episode:
        """Reads one file; raises DatasetError if it is damaged or no demonstration.

        present: the additions that are in it.
        """
        with reading(path), zipfile.ZipFile(path) as archive:
            steps = _length(archive)
            values: dict[str, Any] = {
                name: read_array(
                    archive, name, kind, _shape(name, steps, spaces), f" in a set of {spaces}"
                )
                for name, kind in FIELDS.items()
            }
            for name in ("language_instruction", "success_once", "episode_length", "episode_seed"):
                values[name] = values[name].item()
            episode = cls(**values, **_additions(archive, steps, present))
            _check_values(episode, spaces)
            return episode


# Types; None: a text.
FIELDS: dict[str, type | None] = {
    "rgb": np.uint8,
    "proprio": np.float32,
    "action": np.float32,
    "reward": np.float32,
    "success": np.int32,
    "done": np.int32,
    "language_instruction": None,
    "success_once": np.bool_,
    "episode_length": np.int32,
    "episode_seed": np.int64,
}


def _additions(archive: zipfile.ZipFile, steps: int, present: Collection[str]) -> dict[str, Any]:
    values: dict[str, Any] = {
        name: read_array(archive, name, additions.MAP_TYPE, (steps, *additions.MAPS_SHAPE))
        for name in additions.MAPS
        if name in present
    }
    if additions.SEGMENTATION in present:
        names = read_array(archive, additions.SEGMENT_NAMES, None, (ANY,)).tolist()
        additions.check_segments(names, values[additions.SEGMENTATION])
        values[additions.SEGMENT_NAMES] = names
    for name in additions.ROWS:
        if name in present:
            values[name] = read_array(archive, name, np.float32, (steps, ANY))
            checks.finite(name, values[name])
    if additions.LABELS in present:
        values[additions.LABELS] = labels.load(archive, steps)
    return values


def _shape(name: str, steps: int, spaces: Spaces) -> tuple[int, ...]:
    if name in ("language_instruction", "success_once", "episode_length", "episode_seed"):
        return ()
    rows: dict[str, tuple[int, ...]] = {
        "rgb": checks.IMAGE_SHAPE,
        "proprio": (len(spaces.proprio_names),),
        "action": (len(spaces.action_names),),
    }
    return (steps, *rows.get(name, ()))


def _length(archive: zipfile.ZipFile) -> int:
    value = read_array(archive, "episode_length", np.int32, ()).item()
    return checks.whole_number("episode_length", value, 1, checks.MAX_STEPS)


def _check_values(episode: Episode, spaces: Spaces) -> None:
    """Refuses what no demonstration holds, and what converters and environments cannot take."""
    spaces.check_actions("action", episode.action)
    checks.finite("proprio", episode.proprio)
    checks.finite("reward", episode.reward)
    success = int(episode.success_once)
    for name, last, why in (("success", success, ", as success_once says"), ("done", 1, "")):
        values = getattr(episode, name)
        if values[-1] != last or values[:-1].any():
            raise DatasetError(f"{name} is not 0 until the last step and {last} in that{why}")
    checks.whole_number("episode_seed", episode.episode_seed, 0, checks.MAX_SEED)
    checks.instruction("language_instruction", episode.language_instruction)


class Metadata:
    """What the metadata of one task's episodes say."""

    def __init__(self, path: Path, metadata_path: Path):
        self.path = path
        self.metadata_path = metadata_path
        self.metadata_bytes = _read(metadata_path)
        with reading(metadata_path):
            self.metadata = read_metadata(self.metadata_bytes)
            self.spaces = Spaces.of_metadata(self.metadata)
            self.additions = additions.of_metadata(self.origin)
            self.keeps_failures = self.origin.get("keep_failures") is True
        self.env_id: str = self.metadata["env_id"]

    @property
    def origin(self) -> dict[str, Any]:
        """How engram made the episodes; {} for those of the original benchmark."""
        origin: dict[str, Any] = self.metadata.get("engram", {})
        return origin

    def succeeds(self, index: int) -> bool:
        """Whether an episode is a success, as all are unless failures are kept."""
        return not self.keeps_failures or self.metadata["success_once"][index] is True

    def __len__(self) -> int:
        count: int = self.metadata["num_episodes"]
        return count


class DemonstrationFolder(Metadata, Sequence):
    """The episodes of one task, in order; each is read on access."""

    def __init__(self, path: Path | str):
        super().__init__(Path(path), Path(path) / "metadata.json")
        count: int = self.metadata["num_episodes"]
        self.files: list[Path] = []
        for i in range(count):
            self.files.append(self.path / f"train_data_{i}.npz")
            if not self.files[-1].is_file():
                raise DatasetError(
                    f"'{self.files[-1]}' is missing; metadata.json has {count} episodes"
                )

    def require(self, asked: Collection[str]) -> None:
        """Refuses demonstrations that lack one of these additions."""
        additions.require(self.path, self.additions, asked)

    def loaders(self) -> Iterator[Callable[[], Episode]]:
        """Functions that read the episodes, for threads."""
        return (functools.partial(self._load, index) for index in range(len(self)))

    def __getitem__(self, index):
        if isinstance(index, slice):
            return [self._load(i) for i in range(len(self))[index]]
        return self._load(range(len(self))[index])

    def __iter__(self) -> Iterator[Episode]:
        return map(self._load, range(len(self)))

    def _load(self, index: int) -> Episode:
        episode = Episode.load(self.files[index], self.spaces, self.additions)
        for name, value in (("length", len(episode)), ("seed", episode.episode_seed)):
            listed = self.metadata[f"episode_{name}s"][index]
            if value != listed:
                raise DatasetError(
                    f"'{self.files[index]}' has {name} {value}; metadata.json has {listed}"
                )
        if episode.success_once != self.succeeds(index):
            raise DatasetError(
                f"'{self.files[index]}' has success_once {episode.success_once}; metadata.json has "
                f"{self.succeeds(index)}"
            )
        return episode


def _read(path: Path) -> bytes:
    with reading(path):
        return checks.regular_file(path, _LARGEST_METADATA).read_bytes()


def read_metadata(content: bytes) -> dict[str, Any]:
    """The document, once what is used of it has the form that it must have."""
    text = content.decode()
    document = json.loads(text)
    if not isinstance(document, dict):
        raise DatasetError(f"{checks.short(document)} given; an object needed")
    _check_origin(document, text)
    checks.env_id("env_id", document.get("env_id"))
    count = checks.whole_number(
        "num_episodes", document.get("num_episodes"), 1, checks.MAX_EPISODES
    )
    for name, low, high in (
        ("episode_lengths", 1, checks.MAX_STEPS),
        ("episode_seeds", 0, checks.MAX_SEED),
    ):
        values = document.get(name)
        if not isinstance(values, list) or len(values) != count:
            raise DatasetError(f"{name}: {checks.short(values)} given; a list of {count} needed")
        for value in values:
            checks.whole_number(name, value, low, high)
    successes = document.get("success_once", [True] * count)
    if not isinstance(successes, list) or len(successes) != count:
        raise DatasetError(
            f"success_once: {checks.short(successes)} given; a list of {count} needed"
        )
    return document


def _check_origin(document: dict[str, Any], text: str) -> None:
    """Refuses data of other versions, which this one cannot play again, and edited documents.

    Those that the original's own scripts write have neither a version nor a checksum.
    """
    if "engram" not in document and "checksum" not in document:
        return
    origin = document.get("engram")
    if not isinstance(origin, dict):
        raise DatasetError(f"engram: {checks.short(origin)} given; an object needed")
    if origin.get("version") != engram.__version__:
        raise DatasetError(
            f"of engram {checks.short(origin.get('version'))}, and this is engram "
            f"{engram.__version__}; use the version that collected it, or collect it again"
        )
    documents.check(text)


def find_folders(root: Path | str, ids: Sequence[str] = ()) -> list[DemonstrationFolder]:
    """The data sets in <root>/data_npz, those of `ids` only where any are given."""
    return _found(Path(root) / "data_npz", ids, DemonstrationFolder)


# Where converters write: folders, and the copies of the metadata in those of a task.
RLDS_FOLDER, RLDS_VERSION = "data_rlds", "1.0.0"
LEROBOT_FOLDER = "data_lerobot"
LEROBOT_METADATA = "source_rlds_metadata.json"
HDF5_FOLDER, HDF5_FILE, HDF5_METADATA = "data_hdf5", "demonstrations.hdf5", "metadata.json"
_CONVERTED = {
    "rlds": (RLDS_FOLDER, Path(RLDS_VERSION) / "metadata.json"),
    "lerobot": (LEROBOT_FOLDER, Path(LEROBOT_METADATA)),
    "hdf5": (HDF5_FOLDER, Path(HDF5_METADATA)),
}


def find_metadata(root: Path | str, format: str, ids: Sequence[str] = ()) -> Sequence[Metadata]:
    """Episodes of data sets of a format, which need no NPZ beside them."""
    if format == "npz" or (Path(root) / "data_npz").is_dir():
        return find_folders(root, ids)
    parent, metadata = _CONVERTED[format]
    return _found(Path(root) / parent, ids, lambda path: Metadata(path, path / metadata))


Found = TypeVar("Found", bound=Metadata)


def _found(parent: Path, ids: Sequence[str], load: Callable[[Path], Found]) -> list[Found]:
    if not parent.is_dir():
        raise DatasetError(
            f"'{parent.parent}' has no folder {parent.name}, which `engram collect` makes"
        )
    present = sorted(path.name for path in parent.iterdir() if path.is_dir())
    for env_id in ids:
        if env_id not in present:
            raise DatasetError(
                f"no data of {env_id} in '{parent}'; there are: {', '.join(present)}"
            )
    folders = [load(parent / name) for name in dict.fromkeys(ids or present)]
    if not folders:
        raise DatasetError(f"'{parent}' holds no data sets")
    for folder in folders:  # otherwise two of them could have the same output folder
        if folder.env_id != folder.path.name:
            raise DatasetError(
                f"'{folder.metadata_path}': env_id: '{folder.env_id}' given; "
                f"the name of its folder needed, '{folder.path.name}'"
            )
    return folders


def no_progress(done: int, total: int) -> None:
    """Callback of converters after every episode; does nothing."""
