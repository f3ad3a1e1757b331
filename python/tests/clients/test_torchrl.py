"""TorchRL's wrappers and collectors, as released, on engram's batches and single environments."""

from __future__ import annotations

import pytest

pytest.importorskip("torchrl")

import gymnasium
import numpy as np
import torch
from conftest import ENDING_TASK, TASK
from tensordict import TensorDictBase
from torchrl.collectors import Collector
from torchrl.data import LazyTensorStorage, ReplayBuffer
from torchrl.data.vla import validate_vla_tensordict
from torchrl.envs import GymEnv, GymWrapper, MultiAction, check_env_specs
from torchrl.modules.vla import LeRobotPolicyWrapper
from transitions import assert_transitions

import engram
from engram.integrations.torchrl import EngramVlaEnv

ENVS, STEPS = 3, 60
MODES = ["SAME_STEP", "DISABLED"]  # those in which TorchRL takes batches


def batch(id: str, mode: str, **options) -> GymWrapper:
    return GymWrapper(engram.make_vec(id, ENVS, autoreset_mode=mode, threads=1, **options))


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("id", [TASK, ENDING_TASK])
def test_a_collector_gathers_the_transitions_of_engram(id, mode):
    env = batch(id, mode)
    env.set_seed(5)
    collector = Collector(env, frames_per_batch=ENVS * STEPS, total_frames=ENVS * STEPS)
    buffer = ReplayBuffer(storage=LazyTensorStorage(STEPS), batch_size=STEPS)
    for data in collector:  # (environments, steps)
        buffer.extend(data.transpose(0, 1).contiguous())
    collector.shutdown()
    kept = buffer[:]
    assert_transitions(
        id,
        obs=kept["observation"],
        actions=kept["action"],
        rewards=kept["next", "reward"].squeeze(-1),
        next_obs=kept["next", "observation"],
        ended=kept["next", "done"].squeeze(-1),
        seed=5,
        resets=2,  # set_seed, and the collector
        autoreset_mode="SAME_STEP",
        resets_when_all_end=mode == "SAME_STEP",
    )


def test_gathered_infos_do_not_reveal_the_answer():
    env = batch(TASK, MODES[0])
    data = env.rollout(3)
    names = {name for key in data.keys(True) for name in (key if isinstance(key, tuple) else [key])}
    assert "success_once" in names
    assert not names & {"oracle_info", "task_cue", "target"}
    env.close()


def test_images_and_proprio():
    env = batch(TASK, MODES[0], obs_mode="rgb", image_size=36)
    data = env.rollout(4)
    assert data["rgb"].shape == (ENVS, 4, 36, 36, 6)
    assert data["rgb"].dtype == torch.uint8
    assert not torch.equal(data["proprio"], data["next", "proprio"])
    env.close()


@pytest.mark.parametrize("id", [TASK, ENDING_TASK])
def test_a_single_environment_by_its_id(id):
    env = GymEnv(f"engram/{id}")
    check_env_specs(env)
    collector = Collector(env, frames_per_batch=STEPS, total_frames=STEPS)
    (data,) = list(collector)
    collector.shutdown()
    assert data["next", "done"].sum() >= 1
    inside = ~data["next", "done"].squeeze(-1)[:-1]
    np.testing.assert_array_equal(
        data["next", "observation"][:-1][inside], data["observation"][1:][inside]
    )
    assert not torch.equal(data["observation"], data["next", "observation"])


def test_a_batch_from_gymnasium_make_vec():
    made = gymnasium.make_vec(f"engram/{TASK}", num_envs=ENVS, autoreset_mode="DISABLED")
    env = GymWrapper(made)
    data = env.rollout(STEPS, break_when_any_done=False)
    assert data["next", "done"].sum() == ENVS * (STEPS // 25)
    env.close()


def vla(id: str = TASK, **options) -> EngramVlaEnv:
    return EngramVlaEnv(id, 4, seed=5, threads=1, image_size=32, **options)


def test_the_layout_for_policies_with_words():
    env = vla()
    check_env_specs(env)
    env.set_seed(7)
    data = env.reset()
    validate_vla_tensordict(data, require_action=False)
    batch = engram.make_vec(TASK, 4, obs_mode="rgb", seed=7, image_size=32)
    seen, _ = batch.reset(seed=7)
    assert data["language_instruction"] == list(batch.instructions)
    for i, name in enumerate(("image", "wrist_image")):
        frames = data["observation", name].permute(0, 2, 3, 1).numpy()
        np.testing.assert_array_equal(frames, seen["rgb"][..., 3 * i : 3 * i + 3])
    np.testing.assert_array_equal(data["observation", "state"].numpy(), seen["proprio"])
    env.close()
    batch.close()


def test_groups_play_the_same_episodes_until_they_succeed():
    env = vla("InterceptSlow-VLA-v0", group_size=2)
    horizon = engram.describe("InterceptSlow-VLA-v0")["horizon"]
    acts = torch.tensor([1.0, 0.0, 1.0, 0.0]).unsqueeze(-1)  # the others stand still

    def policy(td: TensorDictBase) -> TensorDictBase:
        return td.set("action", acts * torch.from_numpy(env._batch.act("oracle")))

    data = env.rollout(2 * horizon, policy, break_when_any_done=False)
    ids, first = data["group_id"].squeeze(-1), data["observation", "state"]
    for one, other in ((0, 1), (2, 3)):
        begins = [
            {int(ids[row, t]): first[row, t] for t in reversed(range(ids.shape[1]))}
            for row in (one, other)
        ]
        shared = begins[0].keys() & begins[1].keys()
        assert len(shared) >= 2
        assert all(torch.equal(begins[0][id], begins[1][id]) for id in shared)
    assert not {*ids[0].tolist()} & {*ids[2].tolist()}
    ended = data["next", "done"].squeeze(-1)
    succeeded = data["next", "success"].squeeze(-1)
    assert succeeded[::2].any(dim=1).all()
    assert not succeeded[1::2].any()
    torch.testing.assert_close(data["next", "reward"].squeeze(-1), succeeded.float())
    assert (ended & succeeded == succeeded).all()
    env.close()


def test_lerobot_policies_act_through_its_wrapper():
    class Chunks:
        def predict_action_chunk(self, batch):
            assert batch["observation.images.image"].shape == (4, 3, 32, 32)
            assert len(batch["task"]) == 4
            return batch["observation.state"].new_zeros(4, 8, 7)

    env = vla().append_transform(MultiAction(dim=1, action_key="action"))
    wrapped = LeRobotPolicyWrapper(Chunks(), action_dim=7, chunk_size=8)

    def policy(td: TensorDictBase) -> TensorDictBase:
        return td.set("action", wrapped(td)["vla_action", "chunk"])

    data = env.rollout(3, policy)
    assert data["action"].shape == (4, 3, 8, 7)
    env.close()
