"""Writes demonstrations as one HDF5 file per task, in the layout that robomimic reads.

`data/demo_<n>` is an episode. Images are chunks of one frame, compressed by HDF5's own gzip
filter, so that any frame is read by itself. Threads compress them; HDF5 only appends.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
import zlib
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np

import engram
from engram.datasets import additions, card, frozen
from engram.datasets.collected import EpisodeSource
from engram.datasets.conversion import Writer
from engram.datasets.episodes import HDF5_FILE, HDF5_FOLDER, Episode
from engram.datasets.frozen import FrozenCue
from engram.datasets.labels import Labels
from engram.datasets.work import packed

IMAGES = ("image", "wrist_image")
_LEVEL = 1  # of gzip: more makes files hardly smaller
_GYM = 2  # robomimic's number for environments of Gym


@contextlib.contextmanager
def _new_file(path: Path) -> Iterator[h5py.Group]:
    """`data` of a new file; what the system says of a failure is an OSError, at the end, too."""
    try:
        with h5py.File(path, "x") as file:
            yield file.create_group("data")
    except (OSError, RuntimeError) as error:
        number = re.search(r"errno = (\d+)", str(error))
        if number is None:
            raise
        raise OSError(int(number[1]), os.strerror(int(number[1]))) from error


class _Frames:
    """Images (T, H, W, C), compressed one by one; equal ones, of which waiting makes many, once.

    Compressed as HDF5's gzip filter does it.
    """

    def __init__(self, images: np.ndarray):
        self.shape = images.shape
        self.dtype = images.dtype
        made: dict[bytes, bytes] = {}
        self.chunks = []
        for image in images:
            pixels = packed(image).tobytes()
            if pixels not in made:
                made[pixels] = zlib.compress(pixels, _LEVEL)
            self.chunks.append(made[pixels])

    def write(self, group: h5py.Group, name: str) -> None:
        chunk = (1, *self.shape[1:])
        dataset = group.create_dataset(
            name, self.shape, self.dtype, chunks=chunk, compression="gzip", compression_opts=_LEVEL
        )
        rest = (0,) * (len(self.shape) - 1)
        for step, data in enumerate(self.chunks):
            dataset.id.write_direct_chunk((step, *rest), data)


class _Demonstration:
    """What the file holds of an episode."""

    def __init__(self, episode: Episode, added: Collection[str], cue: FrozenCue):
        self.steps = len(episode)
        self.attributes = {
            "num_samples": self.steps,
            "episode_seed": episode.episode_seed,
            "success": episode.success_once,
            "language_instruction": episode.language_instruction,
        }
        self.arrays = {
            "actions": episode.action,
            "rewards": episode.reward,
            "dones": episode.done,
            "obs/proprio": episode.proprio,
            **{f"obs/{name}": values for name, values in episode.rows(added).items()},
        }
        if cue:
            self.arrays[frozen.COLUMN] = cue.mask(episode)
        cameras = (episode.image, episode.wrist_image)
        self.frames = {f"obs/{key}": _Frames(each) for key, each in zip(IMAGES, cameras)}
        for name, values in episode.maps(added).items():
            for camera, key in enumerate(additions.map_keys(name)):
                self.frames[f"obs/{key}"] = _Frames(values[..., camera, None])
        if additions.LABELS in added and episode.labels is not None:
            self.arrays |= _labels(episode.labels, episode.language_instruction)


def _labels(labels: Labels, instruction: str) -> dict[str, np.ndarray]:
    texts = {f"privileged/{name}": words for name, words in labels.step_texts().items()}
    texts["paraphrases"] = list(dict.fromkeys([instruction, *labels.paraphrases]))
    numbers = {f"privileged/{name}": values for name, values in labels.steps.items()}
    return numbers | {name: _texts(words) for name, words in texts.items()}


def _texts(texts: list[str]) -> np.ndarray:
    """UTF-8, all as long as the longest."""
    encoded = [text.encode() for text in texts]
    length = max(1, *map(len, encoded))
    return np.array(encoded, h5py.string_dtype("utf-8", length))


class _Writer(Writer):
    PLACE = (HDF5_FOLDER, "{}")
    steps = 0
    episodes = 0

    def start(self) -> None:
        self.data = self.enter_context(_new_file(self.path / HDF5_FILE))

    def pack(self, episode: Episode) -> _Demonstration:
        return _Demonstration(episode, self.added, self.cue)

    def add(self, demonstration: _Demonstration) -> None:
        group = self.data.create_group(f"demo_{self.episodes}")
        for name, value in demonstration.attributes.items():
            group.attrs[name] = value
        for name, frames in demonstration.frames.items():
            frames.write(group, name)
        for name, values in demonstration.arrays.items():
            packed = {"compression": "gzip", "compression_opts": _LEVEL} if values.size else {}
            group.create_dataset(name, data=values, **packed)
        self.steps += demonstration.steps
        self.episodes += 1

    def finish(self) -> card.Card:
        self.data.attrs["total"] = self.steps
        self.data.attrs["env_args"] = json.dumps(_env_args(self.folder, self.added))
        if self.segments.names is not None:
            self.data.attrs[additions.SEGMENT_NAMES] = self.segments.names
        return _card(self.folder, self.added, bool(self.cue))


convert = _Writer.convert
is_written = _Writer.is_written


def _env_args(folder: EpisodeSource, added: Collection[str]) -> dict[str, Any]:
    """What robomimic says of an environment."""
    observed = [name for name in (*additions.MAPS, *additions.ROWS) if name in added]
    physics = folder.metadata.get("engram", {}).get("physics", "engram")
    return {
        "env_name": folder.env_id,
        "type": _GYM,
        "env_version": engram.__version__,
        "env_kwargs": {
            "obs_mode": "+".join(["rgb", *observed]),
            "control_mode": folder.spaces.control_mode,
            "joint_proprio": folder.spaces.joint_proprio,
            **({} if physics == "engram" else {"physics": physics}),
        },
    }


def _card(folder: EpisodeSource, added: Collection[str], is_frozen: bool) -> card.Card:
    return card.of_steps(
        folder,
        added,
        ("obs/proprio", "actions", "privileged", "paraphrases"),
        card.map_notes(added, "`obs/{}`, `wrist_{}`", "the attribute of `data`", "16 bits")
        + frozen.notes(is_frozen, "actions"),
        layout="HDF5 in robomimic's layout",
        command="hdf5",
        tags=("HDF5", "robomimic", "engram", "mikasa-robo-vla"),
        facts={"pictures": "gzip (lossless) of 128 x 128, base and wrist camera"},
        use="import h5py\n\n"
        f'with h5py.File("FOLDER/{HDF5_FILE}") as file:\n'
        '    for demonstration in file["data"].values():\n'
        '        demonstration["obs/image"], demonstration["actions"]',
    )
