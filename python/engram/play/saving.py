"""Saves played episodes as demonstrations, in the format of `engram collect` (docs/datasets.md)."""

from __future__ import annotations

import contextlib
import fcntl
import io
import json
import os
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import engram
from engram.datasets import DemonstrationFolder, checks
from engram.datasets.checks import DatasetError

_PLAYER = "engram play"
_TIME = (1980, 1, 1, 0, 0, 0)  # fixed, for reproducible files
_LEVEL = 1


class SaveError(Exception):
    """An episode cannot be saved; the message gives the reason."""


def save(
    out: Path, id: str, seed: int, actions: Sequence[npt.NDArray[np.float32]]
) -> tuple[Path, int]:
    """Replays the actions and writes the episode; returns the file and the folder's episode count.

    Raises:
        SaveError: The episode is no demonstration, or the folder holds other files.
    """
    arrays, instruction = _replay(id, seed, actions)
    arrays["language_instruction"] = np.array(instruction)
    arrays["success_once"] = np.array(True)
    arrays["episode_length"] = np.array(len(actions), np.int32)
    arrays["episode_seed"] = np.array(seed, np.int64)
    checks.env_id("id", id)  # it becomes the name of a folder
    folder = out / "data_npz" / id
    try:
        with _locked(out, folder):
            metadata = _metadata(folder, id)
            number = metadata["num_episodes"]
            file = folder / f"train_data_{number}.npz"
            if os.path.lexists(file):
                raise SaveError(f"'{file}' exists already, but metadata.json lists fewer")
            _write(file, _npz(arrays))
            metadata["num_episodes"] = number + 1
            metadata["episode_lengths"].append(len(actions))
            metadata["success_once"].append(True)
            metadata["reward_sums"].append(float(arrays["reward"].sum(dtype=np.float64)))
            metadata["episode_seeds"].append(seed)
            metadata["engram"]["attempts"] = number + 1
            _write(folder / "metadata.json", (json.dumps(metadata, indent=2) + "\n").encode())
    except (DatasetError, OSError, KeyError, TypeError, AttributeError) as error:
        raise SaveError(f"'{folder}' cannot be written: {error}") from error
    return file, number + 1


def _replay(
    id: str, seed: int, actions: Sequence[npt.NDArray[np.float32]]
) -> tuple[dict[str, npt.NDArray[Any]], str]:
    """Steps of a default environment, as `python -m engram.datasets replay` makes it."""
    rows: dict[str, list[Any]] = {name: [] for name in _STEPS}
    with contextlib.closing(engram.make(id, obs_mode="rgb")) as env:
        observation, _ = env.reset(seed=seed)
        instruction = env.language_instruction
        for action in actions:
            rows["rgb"].append(observation["rgb"])
            rows["proprio"].append(observation["proprio"])
            rows["action"].append(action)
            observation, reward, terminated, truncated, info = env.step(action)
            success = bool(info["success"])
            rows["reward"].append(reward)
            rows["success"].append(success)
            rows["done"].append(success or terminated or truncated)
    successes = rows["success"]
    if not successes or not successes[-1] or any(successes[:-1]):
        raise SaveError("the episode did not succeed; demonstrations do")
    return {name: np.array(rows[name], dtype) for name, dtype in _STEPS.items()}, instruction


_STEPS: Mapping[str, Any] = {
    "rgb": np.uint8,
    "proprio": np.float32,
    "action": np.float32,
    "reward": np.float32,
    "success": np.int32,
    "done": np.int32,
}


def _npz(arrays: Mapping[str, npt.NDArray[Any]]) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED, compresslevel=_LEVEL) as archive:
        for name, array in arrays.items():
            member = zipfile.ZipInfo(f"{name}.npy", _TIME)
            member.compress_type = zipfile.ZIP_DEFLATED
            content = io.BytesIO()
            np.lib.format.write_array(content, np.asarray(array, order="C"), allow_pickle=False)
            archive.writestr(member, content.getvalue())
    return out.getvalue()


@contextlib.contextmanager
def _locked(out: Path, folder: Path) -> Iterator[None]:
    """Creates and locks the folder. Links below `out` are refused: they lead outside of it."""
    out.mkdir(parents=True, exist_ok=True)
    for path in (folder.parent, folder):
        if path.is_symlink():
            raise SaveError(f"'{path}' is a link; a folder needed, or another --out")
        path.mkdir(exist_ok=True)
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise SaveError(f"another process writes to '{folder}'") from None
        yield
    finally:
        os.close(descriptor)


def _metadata(folder: Path, id: str) -> dict[str, Any]:
    """The folder's metadata, or those of an empty one."""
    if not os.path.lexists(folder / "metadata.json"):
        if any(folder.iterdir()):
            raise SaveError(f"'{folder}' holds other files; another --out allowed")
        return _new_metadata(id)
    found = DemonstrationFolder(folder)
    origin = found.metadata.get("engram", {})
    if found.env_id != id or origin.get("player") != _PLAYER:
        raise SaveError(
            f"'{folder}' holds demonstrations that were not played here; another --out allowed"
        )
    if origin.get("version") != engram.__version__:
        raise SaveError(
            f"'{folder}' was played with version {origin.get('version')}, this is "
            f"{engram.__version__}; another --out allowed"
        )
    return found.metadata


def _new_metadata(id: str) -> dict[str, Any]:
    return {
        "env_id": id,
        "num_episodes": 0,
        "episode_lengths": [],
        "success_once": [],
        "reward_sums": [],
        "episode_seeds": [],
        "batched_source_dir": None,
        "unbatched_dir": f"data_npz/{id}",
        "engram": {
            "version": engram.__version__,
            "player": _PLAYER,
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
