"""SheepRL, as released: its command trains on engram's ids, from rows and from pictures."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("sheeprl")

from conftest import TASK

RUN = [
    "env=gym", "env.num_envs=2", "env.sync_env=True", "env.capture_video=False",
    "fabric.accelerator=cpu", "fabric.devices=1", "metric.log_level=1", "metric.log_every=1",
    "algo.run_test=True", "checkpoint.save_last=True", "buffer.memmap=False", "seed=5",
]  # fmt: skip
# One iteration and one update.
PPO = ["exp=ppo", "algo.total_steps=100", "algo.rollout_steps=50", "algo.per_rank_batch_size=50",
       "algo.update_epochs=1"]  # fmt: skip


def run(folder: Path, *settings: str) -> str:
    command = [sys.executable, "-m", "sheeprl", *RUN, *settings]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, (done.stdout + done.stderr)[-3000:]
    return done.stdout + done.stderr


@pytest.mark.parametrize(
    "inputs",
    [
        ["+env.wrapper.obs_mode=objects", "algo.mlp_keys.encoder=[state]"],
        ["+env.wrapper.obs_mode=rgb", "+env.wrapper.image_size=64",
         "+env.wrapper.cameras=[base_camera]",  # its pictures have three channels
         "algo.cnn_keys.encoder=[rgb]",
         "algo.mlp_keys.encoder=[proprio]"],
    ],
    ids=["objects", "rgb"],
)  # fmt: skip
def test_ppo_trains(inputs, tmp_path):
    printed = run(tmp_path, *PPO, f"env.id=engram:engram/{TASK}", *inputs)
    assert "reward_env_0" in printed  # of an episode
    assert list(tmp_path.rglob("*.ckpt"))
