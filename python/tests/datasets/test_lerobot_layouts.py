"""Files of LeRobot data sets, as their documents describe them."""

from __future__ import annotations

import io
import json
import subprocess

import numpy as np
import pytest
from demonstrations import COMMAND, IDS

pytest.importorskip("pyarrow")
pytest.importorskip("av")

import av
import pyarrow.parquet as pq
from PIL import Image

from engram.datasets import find_folders, lerobot
from engram.datasets.__main__ import main
from engram.datasets.frame_stats import floored, of_values
from engram.datasets.lerobot import gr00t
from engram.datasets.spaces import Spaces, continuous

LONG = "RememberColor5-Long-VLA-v0"  # 360 steps, of which most are waiting


def lines(path) -> list[dict]:
    return [json.loads(line) for line in path.read_text().splitlines()]


@pytest.mark.parametrize("frames", ["videos", "images"])
def test_version_2_1_has_a_file_per_episode_and_camera(demonstrations, folder, frames, tmp_path):
    path = lerobot.convert(folder, tmp_path, version="2.1", frames=frames)
    info = json.loads((path / "meta" / "info.json").read_text())
    count = len(folder)
    assert (info["total_episodes"], info["total_chunks"]) == (count, 1)
    episodes = lines(path / "meta" / "episodes.jsonl")
    assert [row["length"] for row in episodes] == folder.metadata["episode_lengths"]
    tasks = {row["task_index"]: row["task"] for row in lines(path / "meta" / "tasks.jsonl")}
    stats = lines(path / "meta" / "episodes_stats.jsonl")
    assert [row["episode_index"] for row in stats] == list(range(count))
    for number, episode in enumerate(folder):
        place = {"episode_chunk": 0, "episode_index": number}
        table = pq.read_table(path / info["data_path"].format(**place))
        assert table.num_rows == len(episode)
        assert {tasks[i] for i in table.column("task_index").to_pylist()} == set(
            episodes[number]["tasks"]
        )
        for key in ("observation.images.top", "observation.images.wrist"):
            assert (key in table.column_names) == (frames == "images")
            if frames == "videos":
                place["video_key"] = key
                assert (path / info["video_path"].format(**place)).stat().st_size > 1000
    assert info["total_videos"] == (2 * count if frames == "videos" else 0)


@pytest.mark.parametrize("version", ["3.0", "2.1"])
def test_statistics_are_of_all_frames_and_floored_at_the_end(folder, version, tmp_path):
    path = lerobot.convert(folder, tmp_path, version=version)
    stats = json.loads((path / "meta" / "stats.json").read_text())
    frames = {
        "observation.state": np.concatenate([continuous(one.proprio) for one in folder]),
        "action": np.concatenate([one.action for one in folder]),
        "frame_index": np.concatenate([np.arange(len(one)) for one in folder])[:, None],
    }
    for key, values in frames.items():
        exact = values.astype(np.float64)
        expected = of_values(exact) if key == "frame_index" else floored(of_values(exact))
        for name, q in (("q01", 0.01), ("q10", 0.1), ("q50", 0.5), ("q90", 0.9), ("q99", 0.99)):
            assert (of_values(exact)[name] == np.quantile(exact, q, axis=0)).all()
        assert stats[key] == {name: found.tolist() for name, found in expected.items()}
    if version == "3.0":  # episodes as they are
        row = pq.read_table(path / "meta/episodes/chunk-000/file-000.parquet").to_pylist()[0]
        std = row["stats/observation.state/std"]
        np.testing.assert_array_equal(std, continuous(folder[0].proprio).astype(np.float64).std(0))


@pytest.mark.parametrize(
    ("spaces", "state", "action", "relative"),
    [
        (
            Spaces(),
            {"position": (0, 3), "rotation": (3, 6), "gripper": (6, 7)},
            {"position": (0, 3), "rotation": (3, 6), "gripper": (6, 7)},
            {"position", "rotation"},
        ),
        (
            Spaces("pd_joint_pos", True),
            {"joint_position": (0, 7), "gripper": (7, 8)},
            {"joint_position": (0, 7), "gripper": (7, 8)},
            set(),
        ),
        (
            Spaces("pd_joint_pos_vel", True),
            {"joint_position": (0, 7), "gripper": (7, 8)},
            {"joint_position": (0, 7), "joint_velocity": (7, 14), "gripper": (14, 15)},
            {"joint_velocity"},
        ),
    ],
)
def test_modalities_are_slices_by_name(spaces, state, action, relative):
    document = gr00t.modality(spaces)
    for group, expected in (("state", state), ("action", action)):
        found = {name: (part["start"], part["end"]) for name, part in document[group].items()}
        assert found == expected
    told = {name for name, part in document["action"].items() if not part.get("absolute", True)}
    assert told == relative


def test_pictures_that_stay_the_same_are_stored_once(tmp_path, capsys):
    command = [*COMMAND, "collect", LONG, IDS[3], "--episodes=1", "--out", tmp_path]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    sizes = {}
    for frames in ("videos", "images", "auto"):
        assert main(["lerobot", str(tmp_path), "--frames", frames]) == 0
        for folder in find_folders(tmp_path):
            path = tmp_path / "data_lerobot" / folder.env_id
            files = [file for file in path.rglob("*") if file.suffix in (".mp4", ".parquet")]
            sizes[folder.env_id, frames] = sum(file.stat().st_size for file in files)
    for id in (LONG, IDS[3]):
        assert sizes[id, "auto"] == min(sizes[id, "videos"], sizes[id, "images"])
    # One waits, the other one moves all the time.
    assert sizes[LONG, "images"] < sizes[LONG, "videos"]
    assert sizes[IDS[3], "images"] > sizes[IDS[3], "videos"]
    (folder,) = find_folders(tmp_path, [LONG])
    distinct = len(np.unique(folder[0].rgb[..., :3].reshape(len(folder[0]), -1), axis=0))
    assert distinct < len(folder[0]) / 2


@pytest.mark.parametrize("frames", ["videos", "images"])
def test_statistics_of_images_are_those_of_decoded_frames(demonstrations, frames, tmp_path):
    """All frames, of episodes of up to 100; videos are lossy."""
    (folder,) = find_folders(demonstrations, [IDS[1]])
    path = lerobot.convert(folder, tmp_path, frames=frames)
    stats = json.loads((path / "meta" / "stats.json").read_text())
    for key in ("observation.images.top", "observation.images.wrist"):
        pixels = decoded(path, key, frames).reshape(-1, 3) / 255
        # Chroma of half the resolution lowers the deviation of a colour.
        allowed = {"rtol": 1e-9} if frames == "images" else {"atol": 0.01}
        found = {name: np.ravel(values) for name, values in stats[key].items()}
        np.testing.assert_allclose(found["mean"], pixels.mean(0), **allowed)
        np.testing.assert_allclose(found["std"], pixels.std(0), **allowed)
        if frames == "images":
            for name, q in (("min", 0), ("q01", 0.01), ("q50", 0.5), ("q99", 0.99), ("max", 1)):
                exact = np.quantile(pixels, q, axis=0, method="inverted_cdf")
                np.testing.assert_allclose(found[name], exact, **allowed)


def decoded(path, key, frames) -> np.ndarray:
    """All frames of a camera, (T, H, W, 3)."""
    if frames == "images":
        files = sorted(path.glob("data/*/*.parquet"))
        columns = [pq.read_table(file, columns=[key]).column(key) for file in files]
        return np.stack(
            [
                np.asarray(Image.open(io.BytesIO(one["bytes"])))
                for column in columns
                for one in column.to_pylist()
            ]
        )
    images = []
    for file in sorted(path.glob(f"videos/{key}/*/*.mp4")):
        with av.open(str(file)) as container:
            images += [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
    return np.stack(images)
