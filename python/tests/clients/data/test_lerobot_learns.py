"""LeRobot's own path from demonstrations to a success rate: reader, policy, `lerobot-eval`."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("lerobot")

import torch
from conftest import TASK
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.policies import make_pre_post_processors
from lerobot.policies.act.configuration_act import ACTConfig
from lerobot.policies.act.modeling_act import ACTPolicy
from lerobot.utils.feature_utils import dataset_to_policy_features

CHUNK = 5


def small_act(meta) -> ACTConfig:
    features = dataset_to_policy_features(meta.features)
    actions = {"action": features.pop("action")}
    return ACTConfig(
        input_features=features,
        output_features=actions,
        chunk_size=CHUNK,
        n_action_steps=CHUNK,
        dim_model=32,
        n_heads=2,
        dim_feedforward=32,
        n_encoder_layers=1,
        n_vae_encoder_layers=1,
        latent_dim=4,
        pretrained_backbone_weights=None,
        device="cpu",
    )


@pytest.fixture(scope="module")
def checkpoint(demonstrations, tmp_path_factory) -> Path:
    """A few steps of ACT on the data set that demonstrations were converted to."""
    torch.manual_seed(1)
    root = demonstrations / "data_lerobot" / TASK
    chunk = {"action": [i / 20 for i in range(CHUNK)]}
    dataset = LeRobotDataset("local/test", root=root, video_backend="pyav", delta_timestamps=chunk)
    config = small_act(dataset.meta)
    policy = ACTPolicy(config)
    before, after = make_pre_post_processors(config, dataset_stats=dataset.meta.stats)
    optimizer = torch.optim.Adam(policy.parameters(), lr=1e-3)
    losses = []
    for batch in [*torch.utils.data.DataLoader(dataset, batch_size=10, shuffle=True)] * 3:
        loss, _ = policy.forward(before(batch))
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        losses.append(loss.item())
    assert losses[-1] < losses[0]
    folder = tmp_path_factory.mktemp("policy")
    for part in (policy, before, after):
        part.save_pretrained(folder)
    return folder


@pytest.mark.parametrize("recording", [False, True])
def test_lerobot_eval_plays_a_checkpoint(checkpoint, recording, tmp_path):
    command = [
        str(Path(sys.executable).with_name("lerobot-eval")),
        "--env.discover_packages_path=engram.integrations.lerobot",
        "--env.type=engram",
        f"--env.task={TASK}",
        f"--policy.path={checkpoint}",
        "--policy.device=cpu",
        "--eval.n_episodes=4",
        # It records one batch only: the second finds the first one's folders.
        f"--eval.batch_size={4 if recording else 2}",
        f"--eval.recording={str(recording).lower()}",
        "--seed=4242424242",
        f"--output_dir={tmp_path}",
    ]
    environment = {**os.environ, "HF_HUB_OFFLINE": "1"}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr[-3000:]
    info = json.loads((tmp_path / "eval_info.json").read_text())
    assert info["overall"]["n_episodes"] == 4
    (task,) = info["per_task"]
    assert task["task_group"] == TASK
    assert set(task["metrics"]["successes"]) <= {True, False}
    assert len(set(task["metrics"]["sum_rewards"])) == 4
    if recording:
        folder = tmp_path / "recordings" / f"{TASK}_0" / "env_1"
        kept = LeRobotDataset("local/again", root=folder, video_backend="pyav")
        assert kept.num_episodes == 1
        first = kept[0]
        assert first["action"].shape == first["agent_pos"].shape == (7,)
        assert first["observation.images.wrist"].shape == (3, 128, 128)
    else:
        assert len(list(tmp_path.rglob("*.mp4"))) == 4
