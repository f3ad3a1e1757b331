"""`lerobot-eval` as released, with the distribution that it imports by itself."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("lerobot")

import numpy as np
from conftest import ENDING_TASK, TASK

ROOT = Path(__file__).parents[4]

# The command itself. ACT has a history of six frames here, in LeRobot's own queue, and keeps still.
PROGRAM = """
import collections
import sys
import numpy, torch
from lerobot.policies.act.modeling_act import ACTPolicy
from lerobot.policies.utils import populate_queues
from lerobot.scripts import lerobot_eval

STATE = "observation.state"
histories, fresh = [], []

def reset(self):
    self._queues = {STATE: collections.deque(maxlen=6)}

def act(self, batch, **_):
    fresh.append(not self._queues[STATE])
    self._queues = populate_queues(self._queues, batch)
    histories.append(torch.stack(list(self._queues[STATE]), 1).numpy())
    return torch.zeros(len(batch[STATE]), 7)

ACTPolicy.reset, ACTPolicy.select_action = reset, act
folder = sys.argv.pop(1)
sys.argv.append(f"--output_dir={folder}/run")
lerobot_eval.main()
numpy.savez(f"{folder}/run.npz", fresh=fresh, histories=numpy.array(histories))
"""


@pytest.fixture(scope="module")
def evaluated(tmp_path_factory):
    """Histories of six frames of a batch of four, in two tasks of unequal length."""
    folder = tmp_path_factory.mktemp("plugin")
    source, installed = folder / "source", folder / "installed"
    shutil.copytree(ROOT / "python/lerobot_env", source)
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-build-isolation"]
    subprocess.run([*pip, "--target", str(installed), str(source)], check=True)
    words = [
        "--env.type=engram",
        f"--env.task={TASK},{ENDING_TASK}",
        "--env.threads=1",
        "--policy.type=act",
        "--policy.pretrained_backbone_weights=null",
        "--policy.dim_model=32",
        "--policy.dim_feedforward=32",
        "--policy.device=cpu",
        "--eval.n_episodes=4",
        "--eval.batch_size=4",
        "--seed=7",
    ]
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, str(folder), *words],
        env={**os.environ, "PYTHONPATH": str(installed), "HF_HUB_OFFLINE": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return np.load(folder / "run.npz")


def test_the_type_alone_is_enough(evaluated):
    assert evaluated["histories"].shape[1:] == (4, 6, 7)


def test_a_history_begins_empty_and_has_frames_of_its_own_episode_alone(evaluated):
    begins = np.flatnonzero(evaluated["fresh"])
    assert len(begins) == 2  # one rollout of each task
    ends = [*begins[1:], len(evaluated["fresh"])]
    assert len({int(end - begin) for begin, end in zip(begins, ends)}) == 2
    for begin, end in zip(begins, ends):
        rows = evaluated["histories"][begin:end]
        newest = rows[:, :, -1]
        for step in range(len(rows)):
            for back in range(6):
                np.testing.assert_array_equal(rows[step, :, -1 - back], newest[max(0, step - back)])
