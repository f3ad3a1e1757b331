"""Writer of demonstrations: appends episodes to a data set in the format of `engram collect`."""

from __future__ import annotations

import io
import os
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from engram._io import documents
from engram._io.files import open_folder, remove_leftovers, write_file
from engram.datasets import checks
from engram.datasets.checks import DatasetError
from engram.datasets.episodes import BENCHMARK, FIELDS, DemonstrationFolder, Episode
from engram.datasets.spaces import Spaces

_TIME = (1980, 1, 1, 0, 0, 0)  # fixed, for reproducible files
_LEVEL = 1
_METADATA = "metadata.json"


def append_episode(
    out: Path,
    env_id: str,
    episode: Episode,
    *,
    player: str,
    version: str,
    spaces: Spaces = BENCHMARK,
) -> tuple[Path, int]:
    """Appends an episode to <out>/data_npz/<env_id>; returns its file and the number of episodes.

    Raises:
        DatasetError: The episode is not of these spaces, or the folder holds other files, or
            demonstrations of another player, version, control mode or proprio.
    """
    checks.env_id("id", env_id)  # it becomes the name of a folder
    _check_widths(episode, spaces)
    folder = out / "data_npz" / env_id
    try:
        with open_folder(out, "data_npz", env_id, lock=True) as descriptor:
            remove_leftovers(descriptor)
            metadata = _metadata(folder, env_id, player, version, spaces)
            number = metadata["num_episodes"]
            name = f"train_data_{number}.npz"
            _drop_unlisted(folder, descriptor, name, spaces)
            metadata["num_episodes"] = number + 1
            metadata["episode_lengths"].append(len(episode))
            metadata["success_once"].append(True)
            metadata["reward_sums"].append(float(episode.reward.sum(dtype=np.float64)))
            metadata["episode_seeds"].append(episode.episode_seed)
            metadata["engram"]["attempts"] = number + 1
            write_file(descriptor, name, _npz(episode))
            try:
                write_file(descriptor, _METADATA, documents.to_text(metadata).encode())
            except BaseException:
                os.unlink(name, dir_fd=descriptor)
                raise
    except (OSError, KeyError, TypeError, AttributeError) as error:
        raise DatasetError(f"'{folder}' cannot be written: {error}") from error
    return folder / name, number + 1


def _check_widths(episode: Episode, spaces: Spaces) -> None:
    for name, names in (("action", spaces.action_names), ("proprio", spaces.proprio_names)):
        width = getattr(episode, name).shape[-1]
        if width != len(names):
            raise DatasetError(f"{name}: {width} numbers given; {len(names)} needed for {spaces}")


def _npz(episode: Episode) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED, compresslevel=_LEVEL) as archive:
        for name, dtype in FIELDS.items():
            member = zipfile.ZipInfo(f"{name}.npy", _TIME)
            member.compress_type = zipfile.ZIP_DEFLATED
            array = np.asarray(getattr(episode, name), dtype, order="C")
            content = io.BytesIO()
            np.lib.format.write_array(content, array, allow_pickle=False)
            archive.writestr(member, content.getvalue())
    return out.getvalue()


def _drop_unlisted(folder: Path, descriptor: int, name: str, spaces: Spaces) -> None:
    """Removes the episode of a process that was killed before it could list it."""
    file = folder / name
    if not os.path.lexists(file):
        return
    if file.is_symlink() or not file.is_file():
        raise DatasetError(f"'{file}' is a link, or no file; move it away, or use another --out")
    Episode.load(file, spaces)  # or it is something else, which stays
    os.unlink(name, dir_fd=descriptor)


def _metadata(
    folder: Path, env_id: str, player: str, version: str, spaces: Spaces
) -> dict[str, Any]:
    """The folder's metadata, or those of an empty one."""
    if not os.path.lexists(folder / _METADATA):
        # A first episode may have been written, but not listed.
        if {path.name for path in folder.iterdir()} - {"train_data_0.npz"}:
            raise DatasetError(f"'{folder}' holds other files; another --out allowed")
        return _new_metadata(env_id, player, version, spaces)
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
    if found.spaces != spaces:
        raise DatasetError(
            f"'{folder}' holds demonstrations of {found.spaces}, this is one of {spaces}; another "
            "--out allowed"
        )
    return found.metadata


def _new_metadata(env_id: str, player: str, version: str, spaces: Spaces) -> dict[str, Any]:
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
            "control_mode": spaces.control_mode,
            "joint_proprio": spaces.joint_proprio,
            "reward_mode": "normalized_dense",
            "variant": None,
            "perturbations": None,
            "attempts": 0,
        },
    }
