"""Readers of episodes in every format, with checks of the contents."""

from __future__ import annotations

import dataclasses
import io
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from engram.datasets import checks
from engram.datasets.checks import DatasetError, reading
from engram.datasets.episodes import DemonstrationFolder

_MOST_ROWS = 10_000_000  # of a file of LeRobot's


@dataclasses.dataclass(frozen=True)
class StoredEpisode:
    """Exactly stored parts of an episode; None for parts that a format lacks."""

    seed: int
    action: np.ndarray  # (T, 7) in [-1, 1]
    proprio: np.ndarray  # (T, 7)
    language_instruction: str
    rgb: np.ndarray | None = None  # (T, H, W, 6)
    reward: np.ndarray | None = None  # (T,)
    success: np.ndarray | None = None  # (T,)

    def __post_init__(self) -> None:
        checks.whole_number("episode_seed", self.seed, 0, checks.MAX_SEED)
        checks.instruction("instruction", self.language_instruction)
        steps = checks.whole_number("steps", len(self.action), 1, checks.MAX_STEPS)
        for name, shape in (
            ("action", (steps, checks.ACTION_DIM)),
            ("proprio", (steps, checks.PROPRIO_DIM)),
            ("rgb", (steps, *checks.PICTURE_SHAPE)),
            ("reward", (steps,)),
            ("success", (steps,)),
        ):
            values = getattr(self, name)
            if values is not None and values.shape != shape:
                raise DatasetError(f"{name} has shape {values.shape}, {shape} expected")
        checks.actions("action", self.action)


def _from_npz(folder: DemonstrationFolder, _: Path) -> Iterator[StoredEpisode]:
    for episode in folder:
        yield StoredEpisode(
            episode.episode_seed,
            episode.action,
            episode.proprio,
            episode.language_instruction,
            episode.rgb,
            episode.reward,
            episode.success,
        )


def _pictures(encoded: list[bytes]) -> np.ndarray:
    """PNG files as (T, H, W, 3); their size is checked before they are unpacked."""
    from PIL import Image

    height, width, channels = checks.CAMERA_SHAPE
    pictures = np.empty((len(encoded), height, width, channels), np.uint8)
    for picture, data in zip(pictures, encoded):
        with Image.open(io.BytesIO(data), formats=["PNG"]) as image:
            if image.size != (width, height) or image.mode != "RGB":
                raise DatasetError(f"a picture of {image.size}, {image.mode}")
            picture[:] = image
    return pictures


def _floats(values: list[float], *shape: int) -> np.ndarray:
    return np.array(values, np.float32).reshape(shape)


# --- RLDS ---


def _from_rlds(folder: DemonstrationFolder, root: Path) -> Iterator[StoredEpisode]:
    from engram.datasets import rlds, tf_example

    path = root / "data_rlds" / folder.env_id / rlds.VERSION
    shards = sorted(path.glob(f"{rlds.NAME}-{rlds.SPLIT}.tfrecord-*"))
    if not shards:
        raise DatasetError(f"'{path}' holds no records")
    for shard in shards:
        with reading(shard), open(shard, "rb") as file:
            for record in tf_example.read_records(file):
                yield _rlds_episode(tf_example.parse_example(record))


def _rlds_episode(fields: dict[str, list]) -> StoredEpisode:
    cameras = [fields[f"steps/observation/{name}"] for name in ("image", "wrist_image")]
    action = _floats(fields["steps/action"], -1, checks.ACTION_DIM)
    if any(len(pictures) != len(action) for pictures in cameras):
        raise DatasetError(f"pictures of {[len(c) for c in cameras]} and {len(action)} steps")
    checks.whole_number("steps", len(action), 1, checks.MAX_STEPS)
    return StoredEpisode(
        fields["episode_metadata/episode_seed"][0],
        action,
        _floats(fields["steps/observation/proprio"], -1, checks.PROPRIO_DIM),
        fields["steps/language_instruction"][0].decode(),
        np.concatenate([_pictures(pictures) for pictures in cameras], axis=-1),
        _floats(fields["steps/reward"], -1),
    )


# --- LeRobot ---


def _from_lerobot(folder: DemonstrationFolder, root: Path) -> Iterator[StoredEpisode]:
    import pyarrow.parquet as pq

    from engram.datasets import lerobot

    path = root / "data_lerobot" / folder.env_id
    files = sorted(path.glob("meta/episodes/*/*.parquet"))
    if not files:
        raise DatasetError(f"'{path}' holds no episodes")
    data: dict[Path, _Rows] = {}  # the file that the last episode was in
    for file in files:
        with reading(file):
            parquet = pq.ParquetFile(file)
            checks.whole_number("rows", parquet.metadata.num_rows, 0, checks.MAX_EPISODES)
            rows = parquet.read(use_threads=False).to_pylist()
        for row in rows:
            with reading(file):
                numbers = {
                    key: checks.whole_number(key, row[name], 0, checks.MAX_EPISODES)
                    for key, name in _PLACE.items()
                }
            index = numbers.pop("episode_index")
            source = path / lerobot.DATA_PATH.format(**numbers)
            with reading(source):
                if source not in data:
                    data = {source: _Rows(pq.ParquetFile(source))}
                yield _lerobot_episode(data[source].of_episode(index), row)


_PLACE = {
    "episode_index": "episode_index",
    "chunk_index": "data/chunk_index",
    "file_index": "data/file_index",
}


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


def _lerobot_episode(table: Any, row: dict[str, Any]) -> StoredEpisode:
    from engram.datasets import lerobot

    columns = table.to_pydict()
    rgb = None
    if lerobot.TOP in columns:  # stored as images, not as lossy videos
        cameras = [[one["bytes"] for one in columns[key]] for key in lerobot.CAMERAS]
        rgb = np.concatenate([_pictures(pictures) for pictures in cameras], axis=-1)
    return StoredEpisode(
        row["episode_seed"],
        np.array(columns["action"], np.float32),
        np.array(columns["observation.state"], np.float32),
        row["tasks"][0],
        rgb,
    )


READERS: dict[str, Callable[[DemonstrationFolder, Path], Iterator[StoredEpisode]]] = {
    "npz": _from_npz,
    "rlds": _from_rlds,
    "lerobot": _from_lerobot,
}
