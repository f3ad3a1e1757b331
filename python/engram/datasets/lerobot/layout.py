"""Names, paths and tables that the versions of LeRobotDataset share."""

from __future__ import annotations

import json
from collections.abc import Collection
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from engram.datasets import additions, checks
from engram.datasets.episodes import LEROBOT_FOLDER
from engram.datasets.spaces import Spaces
from engram.datasets.work import pngs

FOLDER = LEROBOT_FOLDER
ROBOT_TYPE = "mikasa_robo"
SOURCE = "meta/engram.json"  # how engram wrote the folder; LeRobot does not read it

TOP = "observation.images.top"
WRIST = "observation.images.wrist"
CAMERAS = (TOP, WRIST)
STATE = "observation.state"
ACTION = "action"
# Rows beside the state: not under "observation.", where policies would take them for inputs.
ROWS = {additions.STATE: "privileged.state", additions.OBJECTS: "objects"}
COUNTERS = ("timestamp", "frame_index", "episode_index", "index", "task_index")
FILES_PER_CHUNK = 1000
_DICTIONARY_BYTES = 64 << 20  # of different images in a column of an episode


def features(spaces: Spaces, video_infos: dict[str, dict[str, Any]]) -> dict[str, dict[str, Any]]:
    """The entry of info.json; video_infos: properties of videos, of no cameras for images."""
    result: dict[str, dict[str, Any]] = {}
    for key in CAMERAS:
        result[key] = {
            "dtype": "video" if key in video_infos else "image",
            "shape": list(checks.CAMERA_SHAPE),
            "names": ["height", "width", "channel"],
        }
        if key in video_infos:
            result[key]["info"] = video_infos[key]
    for key, names in ((STATE, spaces.proprio_names), (ACTION, spaces.action_names)):
        result[key] = {"dtype": "float32", "shape": [len(names)], "names": list(names)}
    for key in COUNTERS:
        result[key] = {"dtype": scalar_type(key), "shape": [1], "names": None}
    return result


def scalar_type(column: str) -> str:
    return "float32" if column == "timestamp" else "int64"


def table(columns: dict[str, np.ndarray], images: dict[str, np.ndarray]) -> pa.Table:
    """The rows of an episode. Its schema says, in the words of `datasets`, which are images."""
    arrays: dict[str, pa.Array] = {}
    meanings: dict[str, Any] = {}
    for key, values in columns.items():
        scalar = {"dtype": str(values.dtype), "_type": "Value"}
        if values.ndim == 1:
            arrays[key] = pa.array(values)
            meanings[key] = scalar
        else:
            width = values.shape[1]
            arrays[key] = pa.FixedSizeListArray.from_arrays(pa.array(values.ravel()), width)
            meanings[key] = {"feature": scalar, "length": width, "_type": "Sequence"}
    for key, frames in images.items():
        arrays[key] = pa.array(
            [{"bytes": data, "path": None} for data in pngs(frames)],
            pa.struct({"bytes": pa.binary(), "path": pa.string()}),
        )
        meanings[key] = {"_type": "Image"}
    described = json.dumps({"info": {"features": meanings}})
    return pa.table(arrays).replace_schema_metadata({"huggingface": described})


def parquet_writer(file: BinaryIO, schema: pa.Schema) -> pq.ParquetWriter:
    """Equal values of a column are stored once, images among them."""
    return pq.ParquetWriter(file, schema, dictionary_pagesize_limit=_DICTIONARY_BYTES)


def write_names(path: Path, column: str, names: Collection[str]) -> None:
    """A table of numbers, from 0 on, by name."""
    pd.DataFrame({column: range(len(names))}, index=list(names)).to_parquet(path)


def write_json(path: Path, document: dict[str, Any]) -> None:
    path.write_text(json.dumps(document, indent=4) + "\n", "utf-8")
