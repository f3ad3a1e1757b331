"""A sound data set of demonstrations, to convert as it is or to damage."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

import engram
from engram._io import documents

ID = "RememberColor3-VLA-v0"
STEPS = 3
EPISODES = 2


def arrays_of(number: int) -> dict[str, np.ndarray]:
    """The arrays of a sound episode."""
    rng = np.random.default_rng(number)
    last = np.zeros(STEPS, np.int32)
    last[-1] = 1
    return {
        "rgb": np.repeat(rng.integers(0, 255, (STEPS, 1, 1, 6), np.uint8), 128, 1).repeat(128, 2),
        "proprio": rng.normal(size=(STEPS, 7)).astype(np.float32),
        "action": rng.uniform(-1, 1, (STEPS, 7)).astype(np.float32),
        "reward": rng.uniform(0, 1, STEPS).astype(np.float32),
        "success": last,
        "done": last.copy(),
        "language_instruction": np.array("Touch the cube."),
        "success_once": np.array(True),
        "episode_length": np.array(STEPS, np.int32),
        "episode_seed": np.array(number, np.int64),
    }


def sound_metadata() -> dict[str, Any]:
    """The metadata of a sound data set."""
    return {
        "env_id": ID,
        "num_episodes": EPISODES,
        "episode_lengths": [STEPS] * EPISODES,
        "success_once": [True] * EPISODES,
        "reward_sums": [1.5] * EPISODES,
        "episode_seeds": list(range(EPISODES)),
        "batched_source_dir": None,
        "unbatched_dir": f"data_npz/{ID}",
        "engram": {"version": engram.__version__, "renderer": "cpu", "rules": "reference"},
    }


def metadata_text(document: Any) -> str:
    """Writes as a user who knows the checksum; documents may hold what JSON cannot."""
    if not isinstance(document, dict):
        return json.dumps(document)
    line = json.dumps(document, separators=(",", ":"), ensure_ascii=False)
    try:
        checksum = documents.checksum_of(line)
    except UnicodeEncodeError:  # half of a surrogate pair, of which there is no checksum
        return json.dumps(document)
    return json.dumps({**document, "checksum": checksum}, ensure_ascii=False)


def write_sound(root: Path) -> Path:
    """Writes a sound data set below root; returns its folder."""
    folder = root / "data_npz" / ID
    folder.mkdir(parents=True)
    for number in range(EPISODES):
        np.savez_compressed(folder / f"train_data_{number}.npz", **arrays_of(number))
    (folder / "metadata.json").write_text(metadata_text(sound_metadata()))
    return folder


def is_sound(folder: Path) -> bool:
    """True if the folder can be converted, checked independently of engram."""
    metadata = json.loads((folder / "metadata.json").read_text())
    for number in range(metadata["num_episodes"]):
        with np.load(folder / f"train_data_{number}.npz", allow_pickle=False) as file:
            steps = int(file["episode_length"])
            if file["rgb"].shape != (steps, 128, 128, 6) or file["rgb"].dtype != np.uint8:
                return False
            for name in ("action", "proprio"):
                values = file[name]
                if values.shape != (steps, 7) or not np.isfinite(values).all():
                    return False
            if np.abs(file["action"]).max() > 1 or file["reward"].shape != (steps,):
                return False
            listed = (metadata["episode_lengths"][number], metadata["episode_seeds"][number])
            found = (steps, int(file["episode_seed"]))
            if listed != found or not np.isfinite(file["reward"]).all():
                return False
    return metadata["env_id"] == ID


def fit_checksums(root: Path) -> None:
    """Lists files of converted sets as they are now, as a user could who knows engram.json."""
    from engram.datasets import source

    for file in root.glob(f"**/{source.NAME}"):
        folder = file.parent.parent if file.parent.name == "meta" else file.parent
        content = json.loads(file.read_text())
        for name in ("checksum", "files"):
            content.pop(name, None)
        source.write(folder, content, str(file.relative_to(folder)))
