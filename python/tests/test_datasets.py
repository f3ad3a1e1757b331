"""Demonstrations, read by those who are going to read them: numpy, tensorflow_datasets, LeRobot.

Needs the `engram` command: $ENGRAM_CLI, build/release/engram or one on the search path. Readers
that are not installed are skipped; scripts/check_datasets.sh installs them and allows no skipping.
"""

from __future__ import annotations

import importlib
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from engram.datasets import DatasetError, DemonstrationFolder, find_folders
from engram.datasets.__main__ import main

# Seven families; two of them are planned, and the last names an angle in its instruction.
IDS = (
    "RememberColor3-VLA-v0",
    "ShellGameTouch-VLA-v0",
    "FindImposterShape3-VLA-v0",
    "InterceptSlow-VLA-v0",
    "BlinkCountButtonPressEasy-VLA-v0",
    "TraceShapeEasy-VLA-v0",
    "RotateLenientPos-VLA-v0",
)
EPISODES = 2
SEED = 4_242_424_242  # more than 32 bits hold


def require(module: str):
    """The module, or the end of the test: skipped, unless the environment forbids it."""
    if module in os.environ.get("ENGRAM_REQUIRE_READERS", "").split(","):
        return importlib.import_module(module)
    return pytest.importorskip(module)


def cli() -> str:
    build = Path(__file__).parents[2] / "build" / "release" / "engram"
    path = os.environ.get("ENGRAM_CLI") or (
        str(build) if build.exists() else shutil.which("engram")
    )
    if not path:
        pytest.skip("no engram command")
    return path


@pytest.fixture(scope="session")
def root(tmp_path_factory) -> Path:
    """Demonstrations in all three formats."""
    for module in ("pyarrow", "av", "google_crc32c", "PIL", "pandas"):
        require(module)
    folder = tmp_path_factory.mktemp("datasets")
    subprocess.run(
        [cli(), "collect", *IDS, "--episodes", str(EPISODES), "--seed", str(SEED), "--out", folder],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    assert main(["rlds", str(folder)]) == 0
    assert main(["lerobot", str(folder), "--fps", "20"]) == 0
    return folder


@pytest.fixture(params=IDS)
def folder(root, request) -> DemonstrationFolder:
    return find_folders(root, [request.param])[0]


# --- NumPy ---


def test_numpy_reads_the_fields_of_the_table(folder):
    assert len(folder) == EPISODES
    for number, file in enumerate(folder.files):
        with np.load(file, allow_pickle=False) as arrays:
            steps = int(arrays["episode_length"])
            assert steps == folder.metadata["episode_lengths"][number]
            expected = {
                "rgb": ("uint8", (steps, 128, 128, 6)),
                "proprio": ("float32", (steps, 7)),
                "action": ("float32", (steps, 7)),
                "reward": ("float32", (steps,)),
                "success": ("int32", (steps,)),
                "done": ("int32", (steps,)),
                "success_once": ("bool", ()),
                "episode_length": ("int32", ()),
                "episode_seed": ("int64", ()),
            }
            assert set(arrays.files) == {*expected, "language_instruction"}
            for name, (dtype, shape) in expected.items():
                assert (str(arrays[name].dtype), arrays[name].shape) == (dtype, shape), name
            text = arrays["language_instruction"]
            assert text.dtype.kind == "U"
            assert text.shape == ()
            assert text.item().endswith(".")
            assert arrays["success_once"].item() is True
            assert arrays["episode_seed"] == folder.metadata["episode_seeds"][number] >= SEED
            assert np.abs(arrays["action"]).max() <= 1
            assert arrays["rgb"].std() > 5
            success = arrays["success"]
            assert success[-1] == 1
            assert success[:-1].sum() == 0
            np.testing.assert_array_equal(success, arrays["done"])
            total = arrays["reward"].astype(np.float64).sum()
            assert total == pytest.approx(folder.metadata["reward_sums"][number], rel=1e-12)


def test_the_writer_makes_headers_as_numpy_does(folder, tmp_path):
    import io
    import zipfile

    with zipfile.ZipFile(folder.files[0]) as archive, np.load(folder.files[0]) as arrays:
        assert archive.testzip() is None
        for member in archive.infolist():
            assert member.date_time == (1980, 1, 1, 0, 0, 0)
            written = io.BytesIO()
            np.save(written, arrays[member.filename.removesuffix(".npy")])
            assert archive.read(member)[:128] == written.getvalue()[:128], member.filename


# --- RLDS ---


def test_tensorflow_datasets_reads_every_step(root, folder):
    tfds = require("tensorflow_datasets")
    path = root / "data_rlds" / folder.env_id / "1.0.0"
    assert json.loads((path / "metadata.json").read_text()) == folder.metadata
    builder = tfds.builder_from_directory(str(path))
    assert builder.info.full_name == "mikasa_dataset/1.0.0"
    assert builder.info.splits["train"].num_examples == EPISODES
    steps = builder.info.features["steps"]
    assert steps["observation"]["image"].shape == (128, 128, 3)
    assert steps["observation"]["image"].dtype == np.uint8
    assert steps["action"].dtype == np.float32
    read = list(builder.as_dataset(split="train", shuffle_files=False))
    assert len(read) == EPISODES
    for record, episode in zip(read, folder):
        assert record["episode_metadata"]["episode_seed"].numpy() == episode.episode_seed
        assert record["episode_metadata"]["env_id"].numpy().decode() == folder.env_id
        steps = list(record["steps"].as_numpy_iterator())
        assert len(steps) == len(episode)
        for number, step in enumerate(steps):
            observation = step["observation"]
            np.testing.assert_array_equal(observation["image"], episode.image[number])
            np.testing.assert_array_equal(observation["wrist_image"], episode.wrist_image[number])
            np.testing.assert_array_equal(observation["proprio"], episode.proprio[number])
            np.testing.assert_array_equal(step["action"], episode.action[number])
            assert step["reward"] == episode.reward[number]
            assert step["discount"] == 1
            assert step["language_instruction"].decode() == episode.language_instruction
            assert step["is_first"] == (number == 0)
            assert step["is_last"] == step["is_terminal"] == (number + 1 == len(episode))


def test_records_in_several_shards(root, monkeypatch, tmp_path):
    from engram.datasets import rlds

    folder = find_folders(root, [IDS[0]])[0]
    monkeypatch.setattr(rlds, "SHARD_BYTES", 1)
    path = rlds.convert(folder, tmp_path, jobs=1)
    assert len(list(path.glob("*.tfrecord-*-of-00002"))) == 2
    tfds = require("tensorflow_datasets")
    builder = tfds.builder_from_directory(str(path))
    assert sum(1 for _ in builder.as_dataset(split="train")) == EPISODES


# --- LeRobot ---


@pytest.fixture
def lerobot_dataset(monkeypatch):
    monkeypatch.setenv("HF_HUB_OFFLINE", "1")
    module = require("lerobot.datasets.lerobot_dataset")
    return lambda path: module.LeRobotDataset("local/test", root=path, video_backend="pyav")


@pytest.mark.parametrize("images", [False, True])
def test_lerobot_reads_every_frame(root, folder, images, lerobot_dataset, tmp_path):
    path = root / "data_lerobot" / folder.env_id
    if images:
        assert (
            main(
                [
                    "lerobot",
                    str(root),
                    folder.env_id,
                    "--images",
                    "--out",
                    str(tmp_path),
                    "--fps",
                    "20",
                ]
            )
            == 0
        )
        path = tmp_path / "data_lerobot" / folder.env_id
    dataset = lerobot_dataset(path)
    assert dataset.fps == 20
    assert dataset.meta.robot_type == "mikasa_robo"
    assert dataset.num_episodes == EPISODES
    assert len(dataset) == sum(folder.metadata["episode_lengths"])
    assert json.loads((path / "source_rlds_metadata.json").read_text()) == folder.metadata
    state_stats = dataset.meta.stats["observation.state"]
    number = 0
    for index, episode in enumerate(folder):
        assert dataset.meta.episodes[index]["episode_seed"] == episode.episode_seed
        for step in range(len(episode)):
            item = dataset[number]
            number += 1
            np.testing.assert_array_equal(item["observation.state"].numpy(), episode.proprio[step])
            np.testing.assert_array_equal(item["action"].numpy(), episode.action[step])
            assert item["task"] == episode.language_instruction
            assert (item["episode_index"], item["frame_index"]) == (index, step)
            assert item["timestamp"].item() == pytest.approx(step / 20)
            assert (episode.proprio[step] >= state_stats["min"]).all()
            for key, image in (("top", episode.image[step]), ("wrist", episode.wrist_image[step])):
                seen = item[f"observation.images.{key}"].permute(1, 2, 0).numpy() * 255
                assert seen.shape == (128, 128, 3)
                error = np.abs(seen - image)
                # Videos are lossy, but show the right frame: neighbours in the wrist camera, which
                # moves, differ by more. Images are exact.
                assert error.max() < 0.01 if images else error.mean() < 9, (key, index, step)


# --- playing again ---


@pytest.mark.parametrize("format_name", ["npz", "rlds", "lerobot"])
def test_actions_played_again_show_the_same(root, format_name, capsys):
    require("engram._core")
    assert main(["replay", str(root), "--format", format_name, "--json"]) == 0
    results = json.loads(capsys.readouterr().out)
    assert {result["env_id"] for result in results} == set(IDS)
    for result in results:
        assert result["equal"], result
        assert result["episodes"] == EPISODES
        assert result["steps"] > 2 * 9


# The lamp game draws what goes where unless the original's rules fix it.
def test_replay_follows_the_rules_of_the_data(tmp_path, capsys):
    require("engram._core")
    task = "ShellGameColorLampTouch-VLA-v0"
    command = [cli(), "collect", task, "--episodes", "2", "--rules", "original", "--out", tmp_path]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    metadata = json.loads((tmp_path / "data_npz" / task / "metadata.json").read_text())
    assert metadata["engram"]["rules"] == "original"
    assert main(["replay", str(tmp_path), "--json"]) == 0
    (result,) = json.loads(capsys.readouterr().out)
    assert result["equal"], result


def test_a_changed_action_is_noticed(root, tmp_path, capsys):
    require("engram._core")
    from engram.datasets import rlds  # noqa: F401 (its libraries are there)

    target = tmp_path / "data_npz" / IDS[0]
    shutil.copytree(root / "data_npz" / IDS[0], target)
    file = target / "train_data_1.npz"
    with np.load(file) as stored:
        arrays = dict(stored)
    arrays["action"][-3, 0] += 0.25
    np.savez(file, **arrays)
    assert main(["replay", str(tmp_path), "--json"]) == 1
    (result,) = json.loads(capsys.readouterr().out)
    assert list(result["different"]) == ["1"]
    assert any("proprio" in text for text in result["different"]["1"])


# --- what is refused ---


def test_damaged_files_are_told(root, tmp_path, capsys):
    target = tmp_path / "data_npz" / IDS[0]
    shutil.copytree(root / "data_npz" / IDS[0], target)
    file = target / "train_data_1.npz"
    whole = file.read_bytes()
    for damaged in (b"", whole[: len(whole) // 2], whole[:5000] + b"????" + whole[5004:]):
        file.write_bytes(damaged)
        assert main(["rlds", str(tmp_path), "--jobs", "1"]) == 1
        assert "train_data_1.npz" in capsys.readouterr().err
        # Nothing half-written is left behind.
        assert not list((tmp_path / "data_rlds").rglob("*.*"))
    file.unlink()
    with pytest.raises(DatasetError, match="is missing"):
        find_folders(tmp_path)
    assert main(["lerobot", str(tmp_path / "nothing")]) == 1
    assert "has no folder data_npz" in capsys.readouterr().err
    with pytest.raises(DatasetError, match=IDS[1]):
        find_folders(tmp_path, [IDS[1]])


def test_runs_as_a_module():
    result = subprocess.run(
        [sys.executable, "-m", "engram.datasets", "--help"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert "lerobot" in result.stdout
