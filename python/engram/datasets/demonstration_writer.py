"""Writer of demonstrations: appends episodes to a data set in the format of `engram collect`."""

from __future__ import annotations

import contextlib
import fcntl
import io
import json
import os
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from engram.datasets import checks
from engram.datasets.checks import DatasetError
from engram.datasets.episodes import FIELDS, DemonstrationFolder, Episode

_TIME = (1980, 1, 1, 0, 0, 0)  # fixed, for reproducible files
_LEVEL = 1


def append_episode(
    out: Path, env_id: str, episode: Episode, *, player: str, version: str
) -> tuple[Path, int]:
    """Appends an episode to <out>/data_npz/<env_id>; returns its file and the number of episodes.

    Raises:
        DatasetError: The folder holds other files, or demonstrations of another player or version.
    """
    checks.env_id("id", env_id)  # it becomes the name of a folder
    folder = out / "data_npz" / env_id
    try:
        with _locked(out, folder):
            metadata = _metadata(folder, env_id, player, version)
            number = metadata["num_episodes"]
            file = folder / f"train_data_{number}.npz"
            if os.path.lexists(file):
                raise DatasetError(f"'{file}' exists already, but metadata.json lists fewer")
            _write(file, _npz(episode))
            metadata["num_episodes"] = number + 1
            metadata["episode_lengths"].append(len(episode))
            metadata["success_once"].append(True)
            metadata["reward_sums"].append(float(episode.reward.sum(dtype=np.float64)))
            metadata["episode_seeds"].append(episode.episode_seed)
            metadata["engram"]["attempts"] = number + 1
            _write(folder / "metadata.json", (json.dumps(metadata, indent=2) + "\n").encode())
    except (OSError, KeyError, TypeError, AttributeError) as error:
        raise DatasetError(f"'{folder}' cannot be written: {error}") from error
    return file, number + 1


def _npz(episode: Episode) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED, compresslevel=_LEVEL) as archive:
        for name, (dtype, _) in FIELDS.items():
            member = zipfile.ZipInfo(f"{name}.npy", _TIME)
            member.compress_type = zipfile.ZIP_DEFLATED
            array = np.asarray(getattr(episode, name), dtype, order="C")
            content = io.BytesIO()
            np.lib.format.write_array(content, array, allow_pickle=False)
            archive.writestr(member, content.getvalue())
    return out.getvalue()


@contextlib.contextmanager
def _locked(out: Path, folder: Path) -> Iterator[None]:
    """Creates and locks the folder. Links below `out` are refused: they lead outside of it."""
    out.mkdir(parents=True, exist_ok=True)
    for path in (folder.parent, folder):
        if path.is_symlink():
            raise DatasetError(f"'{path}' is a link; a folder needed, or another --out")
        path.mkdir(exist_ok=True)
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise DatasetError(f"another process writes to '{folder}'") from None
        yield
    finally:
        os.close(descriptor)


def _metadata(folder: Path, env_id: str, player: str, version: str) -> dict[str, Any]:
    """The folder's metadata, or those of an empty one."""
    if not os.path.lexists(folder / "metadata.json"):
        if any(folder.iterdir()):
            raise DatasetError(f"'{folder}' holds other files; another --out allowed")
        return _new_metadata(env_id, player, version)
    found = DemonstrationFolder(folder)
    origin = found.metadata.get("engram", {})
    if found.env_id != env_id or origin.get("player") != player:
        raise DatasetError(
            f"'{folder}' holds demonstrations that {player} did not write; another --out allowed"
        )
    if origin.get("version") != version:
        raise DatasetError(
            f"'{folder}' holds demonstrations of version {origin.get('version')}, this is "
            f"{version}; another --out allowed"
        )
    return found.metadata


def _new_metadata(env_id: str, player: str, version: str) -> dict[str, Any]:
    return {
        "env_id": env_id,
        "num_episodes": 0,
        "episode_lengths": [],
        "success_once": [],
        "reward_sums": [],
        "episode_seeds": [],
        "batched_source_dir": None,
        "unbatched_dir": f"data_npz/{env_id}",
        "engram": {
            "version": version,
            "player": player,
            "start_seed": None,
            "renderer": "cpu",
            "rules": "reference",
            "control_mode": "pd_ee_delta_pose",
            "reward_mode": "normalized_dense",
            "variant": None,
            "attempts": 0,
        },
    }


def _write(path: Path, content: bytes) -> None:
    """Writes a file atomically."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}.engram-tmp")
    try:
        with open(temporary, "xb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)
