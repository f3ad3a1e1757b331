"""Plays stored actions in fresh environments and compares what they show with what is stored.

An episode is determined by its task, its seed and its actions: `engram.make(id, obs_mode="rgb")`,
with the rules of the metadata, `reset(seed=seed)`, then one `step` per action.
"""

from __future__ import annotations

import dataclasses
import io
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path

import numpy as np

from engram.datasets.episodes import DatasetError, DemonstrationFolder, no_progress


@dataclasses.dataclass(frozen=True)
class StoredEpisode:
    """What a format holds exactly of an episode; None where it does not."""

    seed: int
    action: np.ndarray  # (T, 7)
    proprio: np.ndarray  # (T, 7)
    language_instruction: str
    rgb: np.ndarray | None = None  # (T, H, W, 6)
    reward: np.ndarray | None = None  # (T,)
    success: np.ndarray | None = None  # (T,)


def differences(env, episode: StoredEpisode) -> list[str]:
    """Plays one episode; returns what is not the same bit for bit, the first step of each field.

    env: an `engram.Env` of the episode's task with obs_mode "rgb".
    """
    observation, _ = env.reset(seed=episode.seed)
    found: dict[str, str] = {}

    def check(field: str, step: int, shown, stored) -> None:
        if stored is None or field in found:
            return
        shown = np.asarray(shown, stored.dtype)
        if shown.tobytes() != np.ascontiguousarray(stored[step]).tobytes():
            found[field] = f"{field} of step {step}"

    if env.language_instruction != episode.language_instruction:
        found["language_instruction"] = "language_instruction"
    for step, action in enumerate(episode.action):
        check("rgb", step, observation["rgb"], episode.rgb)
        check("proprio", step, observation["proprio"], episode.proprio)
        observation, reward, _, _, info = env.step(action)
        check("reward", step, reward, episode.reward)
        check("success", step, info["success"], episode.success)
    if not info["success"]:
        found["end"] = "success at the end"
    return list(found.values())


def compare(
    folder: DemonstrationFolder,
    root: Path | str,
    source: str,
    episodes: int | None = None,
    progress: Callable[[int, int], None] = no_progress,
) -> dict:
    """Plays the episodes of one task as one format holds them."""
    import engram  # the compiled part, which nothing else here needs

    count = min(len(folder), episodes or len(folder))
    made_how = folder.metadata.get("engram", {})
    env = engram.make(
        folder.env_id,
        obs_mode="rgb",
        renderer=made_how.get("renderer", "cpu"),
        rules=made_how.get("rules", "reference"),
    )
    different = {}
    steps = 0
    played = 0
    for number, episode in enumerate(islice(_READERS[source](folder, Path(root)), count)):
        found = differences(env, episode)
        if found:
            different[number] = found
        steps += len(episode.action)
        played += 1
        progress(played, count)
    env.close()
    if played < count:
        raise DatasetError(f"{folder.env_id}: {played} episodes as {source}, {count} expected")
    return {
        "env_id": folder.env_id,
        "format": source,
        "episodes": count,
        "steps": steps,
        "equal": not different,
        "different": different,
    }


# --- the formats ---


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


def _from_rlds(folder: DemonstrationFolder, root: Path) -> Iterator[StoredEpisode]:
    from PIL import Image

    from engram.datasets import rlds, tf_example

    def images(encoded: list[bytes]) -> np.ndarray:
        return np.stack([np.asarray(Image.open(io.BytesIO(data))) for data in encoded])

    def floats(values: list[float], *shape: int) -> np.ndarray:
        return np.array(values, np.float32).reshape(shape)

    path = root / "data_rlds" / folder.env_id / rlds.VERSION
    shards = sorted(path.glob(f"{rlds.NAME}-{rlds.SPLIT}.tfrecord-*"))
    if not shards:
        raise DatasetError(f"'{path}' holds no records")
    for shard in shards:
        with open(shard, "rb") as file:
            for record in tf_example.read_records(file):
                fields = tf_example.parse_example(record)
                rgb = [
                    images(fields[f"steps/observation/{name}"]) for name in ("image", "wrist_image")
                ]
                yield StoredEpisode(
                    fields["episode_metadata/episode_seed"][0],
                    floats(fields["steps/action"], -1, 7),
                    floats(fields["steps/observation/proprio"], -1, 7),
                    fields["steps/language_instruction"][0].decode(),
                    np.concatenate(rgb, axis=-1),
                    floats(fields["steps/reward"], -1),
                )


def _from_lerobot(folder: DemonstrationFolder, root: Path) -> Iterator[StoredEpisode]:
    import pyarrow.parquet as pq
    from PIL import Image

    from engram.datasets import lerobot

    path = root / "data_lerobot" / folder.env_id
    rows = [
        row
        for file in sorted(path.glob("meta/episodes/*/*.parquet"))
        for row in pq.read_table(file).to_pylist()
    ]
    if not rows:
        raise DatasetError(f"'{path}' holds no episodes")
    for row in rows:
        place = {key: row[f"data/{key}"] for key in ("chunk_index", "file_index")}
        file = path / lerobot.DATA_PATH.format(**place)
        table = pq.read_table(file, filters=[("episode_index", "=", row["episode_index"])])
        columns = table.to_pydict()
        rgb = None
        if lerobot.TOP in columns:  # stored as images, not as lossy videos
            rgb = np.stack(
                [
                    np.concatenate(
                        [
                            np.asarray(Image.open(io.BytesIO(columns[key][step]["bytes"])))
                            for key in lerobot.CAMERAS
                        ],
                        axis=-1,
                    )
                    for step in range(table.num_rows)
                ]
            )
        yield StoredEpisode(
            row["episode_seed"],
            np.array(columns["action"], np.float32),
            np.array(columns["observation.state"], np.float32),
            row["tasks"][0],
            rgb,
        )


_READERS = {"npz": _from_npz, "rlds": _from_rlds, "lerobot": _from_lerobot}
