"""`engram collect --format rl`, read as loaders of offline agents read the published data."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest
from demonstrations import COMMAND

import engram

ID = "RememberColor3-v0"
STEPS = 60
EPISODES = 3


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """The folder, and what the command printed."""
    folder = tmp_path_factory.mktemp("rl")
    done = subprocess.run(
        [*COMMAND, "collect", ID, "--format=rl", f"--episodes={EPISODES}", "--seed=5", "--json",
         "--out", folder],
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    return folder, json.loads(done.stdout)


def load(folder: Path) -> dict[str, np.ndarray]:
    """Every train_data_<i>.npz of a task, stacked."""
    files = sorted(folder.glob("*"), key=lambda path: int(path.stem.rpartition("_")[2]))
    assert [path.name for path in files] == [f"train_data_{i}.npz" for i in range(EPISODES)]
    episodes = [dict(np.load(path)) for path in files]
    return {key: np.stack([episode[key] for episode in episodes]) for key in episodes[0]}


def test_the_document(data):
    folder, document = data
    (task,) = document["tasks"]
    assert document["format"] == "rl"
    assert task["out"] == str(folder / "MIKASA-Robo" / "unbatched" / ID)
    assert (task["episodes"], task["steps"]) == (EPISODES, EPISODES * STEPS)
    assert task["success_once"] == 1
    plan = json.loads((folder / "MIKASA-Robo" / f"{ID}.json").read_text())
    assert plan["engram"]["start_seed"] == 5
    assert plan["engram"]["control_mode"] == "pd_joint_delta_pos"


def test_a_loader_of_offline_agents(data):
    arrays = load(Path(data[1]["tasks"][0]["out"]))
    shapes = {
        "rgb": ((128, 128, 6), np.uint8), "joints": ((25,), np.float32),
        "action": ((8,), np.float32), "reward": ((), np.float32), "success": ((), np.int64),
        "done": ((), np.int64),
    }  # fmt: skip
    assert list(arrays) == list(shapes)
    for key, (shape, dtype) in shapes.items():
        assert arrays[key].shape == (EPISODES, STEPS, *shape), key
        assert arrays[key].dtype == dtype, key
    # Episodes go on to the horizon; terminations are ignored.
    assert arrays["done"][:, :-1].sum() == 0
    assert arrays["done"][:, -1].all()
    assert arrays["success"].any(axis=1).all()
    assert np.isfinite(arrays["reward"]).all()
    assert (arrays["reward"][arrays["success"] == 1] == 1).all()
    # As agents use them: pictures with channels first, returns to go of success, windows of steps.
    pictures = arrays["rgb"].transpose(0, 1, 4, 2, 3).astype(np.float32) / 255
    assert pictures.shape[2:] == (6, 128, 128)
    to_go = np.cumsum(arrays["success"][:, ::-1], axis=1)[:, ::-1]
    assert (to_go[:, 0] == arrays["success"].sum(axis=1)).all()
    windows = np.lib.stride_tricks.sliding_window_view(arrays["action"], 20, axis=1)
    assert windows.shape == (EPISODES, STEPS - 19, 8, 20)


def test_actions_played_again_give_the_same_episode(data):
    arrays = load(Path(data[1]["tasks"][0]["out"]))
    env = engram.make_vec(
        ID, EPISODES, seed=5, obs_mode="rgb", autoreset_mode="DISABLED",
        terminate_on_success=False, threads=1,
    )  # fmt: skip
    observation, _ = env.reset(seed=5)
    for t in range(STEPS):
        np.testing.assert_array_equal(observation["rgb"], arrays["rgb"][:, t])
        observation, reward, *_, info = env.step(arrays["action"][:, t])
        np.testing.assert_array_equal(reward, arrays["reward"][:, t])
        np.testing.assert_array_equal(info["success"], arrays["success"][:, t])
    env.close()
