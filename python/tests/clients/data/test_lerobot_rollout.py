"""LeRobot's own functions, as released: registration of the environment, rollouts, evaluation."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("lerobot")

import gymnasium
import numpy as np
import torch
from conftest import ENDING_TASK, TASK
from lerobot.envs import EnvConfig, close_envs, make_env
from lerobot.envs.factory import make_env_config, make_env_pre_post_processors
from lerobot.envs.utils import check_env_attributes_and_types, env_to_policy_features
from lerobot.policies import PreTrainedPolicy
from lerobot.policies.act.configuration_act import ACTConfig
from lerobot.scripts.lerobot_eval import eval_policy_all, rollout

import engram
import engram.integrations.lerobot
from engram.datasets.spaces import continuous
from engram.integrations.lerobot import LeRobotPolicy
from engram.integrations.periodic import PeriodicEvaluation

SEED = 4242424242


class Player(PreTrainedPolicy):
    """One of engram's own policies in LeRobot's clothes."""

    config_class = ACTConfig
    name = "engram_player"

    def __init__(self, policy: str = "oracle"):
        super().__init__(ACTConfig())
        self.policy, self.batch, self.seen = policy, None, []

    def select_action(self, batch, **_):
        self.seen.append(batch)
        return torch.from_numpy(self.batch.act(self.policy))

    def reset(self):
        self.seen = []

    def get_optim_params(self):
        return {}

    def forward(self, batch, **_):
        raise NotImplementedError

    def predict_action_chunk(self, batch, **_):
        raise NotImplementedError


def pipelines(config) -> dict:
    env_pre, env_post = make_env_pre_post_processors(config, ACTConfig())
    return {
        "env_preprocessor": env_pre,
        "env_postprocessor": env_post,
        # The policy's own, which has none.
        "preprocessor": lambda observation: observation,
        "postprocessor": lambda action: action,
    }


@pytest.fixture
def config():
    return make_env_config("engram", task=TASK)


@pytest.fixture
def envs(config):
    made = make_env(config, n_envs=3)
    yield made
    close_envs(made)


def own_episodes(id: str, count: int, policy: str) -> list[dict]:
    """Rollouts in a loop of our own: one environment per episode."""
    played = []
    env = engram.make(id)
    for number in range(count):
        env.reset(seed=SEED + number)
        rewards, over = [], False
        while not over:
            _, reward, terminated, truncated, info = env.step(env.act(policy))
            rewards.append(reward)
            over = terminated or truncated
        played.append({"rewards": rewards, "success": info["success_once"]})
    env.close()
    return played


def test_the_type_is_registered(config):
    assert "engram" in EnvConfig.get_known_choices()
    assert isinstance(config, engram.integrations.lerobot.EngramEnvConfig)
    features = env_to_policy_features(config)
    assert features["observation.images.top"].shape == (3, 128, 128)
    assert features["observation.images.wrist"].shape == (3, 128, 128)
    assert features["observation.state"].shape == (7,)
    assert features["action"].shape == (7,)


def test_several_tasks_of_other_sizes():
    config = make_env_config("engram", task=f"{TASK}, {ENDING_TASK}", image_size=36, threads=1)
    made = make_env(config, n_envs=2)
    assert list(made) == [TASK, ENDING_TASK]
    for id, group in made.items():
        env = group[0]
        assert isinstance(env, gymnasium.vector.VectorEnv)
        obs, _ = env.reset(seed=1)
        assert env.observation_space.contains(obs)
        assert obs["pixels"]["wrist"].shape == (2, 36, 36, 3)
        assert env.call("task") == (id, id)
    close_envs(made)


def test_the_control_mode_sets_the_features():
    config = make_env_config("engram", task=TASK, control_mode="pd_joint_delta_pos")
    assert env_to_policy_features(config)["action"].shape == (8,)
    made = make_env(config, n_envs=2)
    assert made[TASK][0].single_action_space.shape == (8,)
    close_envs(made)
    joints = make_env_config("engram", task=TASK, joint_proprio=True)
    assert env_to_policy_features(joints)["observation.state"].shape == (8,)
    made = make_env(joints, n_envs=2)
    obs, _ = made[TASK][0].reset(seed=[1, 2])
    assert made[TASK][0].observation_space.contains(obs)
    assert obs["agent_pos"].shape == (2, 8)
    close_envs(made)
    with pytest.raises(engram.InvalidArgumentError, match="angles: 'degrees' given"):
        engram.integrations.lerobot.LeRobotEnv(TASK, 1, angles="degrees")


def test_environments_are_complete(envs, recwarn):
    check_env_attributes_and_types(envs[TASK][0])
    assert not recwarn.list


@pytest.mark.parametrize(
    ("id", "angles"), [(TASK, "continuous"), (ENDING_TASK, "continuous"), (TASK, "benchmark")]
)
def test_a_rollout_equals_that_of_engram(id, angles):
    config = make_env_config("engram", task=id, angles=angles)
    env = make_env(config, n_envs=3)[id][0]
    policy = Player("oracle")
    policy.batch = env.unwrapped
    seeds = [SEED, SEED + 1, SEED + 2]
    result = rollout(env, policy, seeds=seeds, return_observations=True, **pipelines(config))
    expected = own_episodes(id, 3, "oracle")
    for number, episode in enumerate(expected):
        length = len(episode["rewards"])
        assert int(result["done"][number].int().argmax()) + 1 == length
        np.testing.assert_array_equal(result["reward"][number, :length], episode["rewards"])
        assert bool(result["success"][number, :length].any()) == episode["success"]
    # Observations of policies and of the rollout belong to the right step.
    obs, _ = (batch := engram.make_vec(id, 3, obs_mode="rgb")).reset(seed=seeds)
    top = result["observation"]["observation.images.top"]
    assert top.shape[2:] == (3, 128, 128)
    for step in range(min(len(episode["rewards"]) for episode in expected)):
        pictures = obs["rgb"].transpose(0, 3, 1, 2).astype(np.float32) / 255
        np.testing.assert_array_equal(top[:, step], pictures[:, :3])
        seen = policy.seen[step]
        np.testing.assert_array_equal(seen["observation.images.wrist"], pictures[:, 3:])
        state = continuous(obs["proprio"]) if angles == "continuous" else obs["proprio"]
        np.testing.assert_array_equal(seen["observation.state"], state)
        assert seen["task"] == [batch.envs[i].language_instruction for i in range(3)]
        obs = batch.step(batch.act("oracle"))[0]
    batch.close()
    env.close()


def test_ended_environments_hold_their_last_frame():
    env = engram.integrations.lerobot.LeRobotEnv(ENDING_TASK, 3)
    env.reset(seed=[SEED, SEED + 1, SEED + 2])
    held, reports, over = {}, np.zeros(3, int), np.zeros(3, bool)
    while not over.all():
        obs, reward, terminated, truncated, info = env.step(env.batch.act("oracle"))
        for number, (image, state) in held.items():
            np.testing.assert_array_equal(obs["pixels"]["top"][number], image)
            np.testing.assert_array_equal(obs["agent_pos"][number], state)
            assert reward[number] == 0
        reports += info.get("_final_info", np.zeros(3, bool))
        over |= terminated | truncated
        for number in np.flatnonzero(over):
            image, state = obs["pixels"]["top"][number], obs["agent_pos"][number]
            held.setdefault(number, (image.copy(), state.copy()))
    assert reports.tolist() == [1, 1, 1]
    env.close()


@pytest.mark.parametrize("policy_name", ["oracle", "zero"])
def test_an_evaluation_counts_as_engram_does(envs, config, policy_name, tmp_path):
    policy = Player(policy_name)
    policy.batch = envs[TASK][0].unwrapped
    info = eval_policy_all(
        envs,
        policy,
        n_episodes=6,
        start_seed=SEED,
        max_episodes_rendered=1,
        videos_dir=tmp_path,
        **pipelines(config),
    )
    expected = own_episodes(TASK, 6, policy_name)
    (task,) = info["per_task"]
    assert task["metrics"]["successes"] == [episode["success"] for episode in expected]
    assert task["metrics"]["sum_rewards"] == pytest.approx(
        [sum(episode["rewards"]) for episode in expected], rel=1e-5
    )
    assert info["overall"]["pc_success"] == (100 if policy_name == "oracle" else 0)
    (video,) = info["overall"]["video_paths"]
    assert Path(video).stat().st_size > 1000


def test_four_batches_of_thirty_two_play_128_episodes(monkeypatch):
    small = make_env_config("engram", task=TASK, image_size=16, threads=1)
    made = make_env(small, n_envs=32)
    env, rows = made[TASK][0], []
    reset = env.reset

    def noted(**arguments):
        result = reset(**arguments)
        rows.extend(result[0]["agent_pos"].copy())
        return result

    monkeypatch.setattr(env, "reset", noted)
    policy = Player("zero")
    policy.batch = env.unwrapped
    info = eval_policy_all(made, policy, n_episodes=128, start_seed=SEED, **pipelines(small))
    assert len(info["per_task"][0]["metrics"]["successes"]) == 128
    assert len(rows) == len(np.unique(rows, axis=0)) == 128
    close_envs(made)


def test_env_hub_loads_it(monkeypatch, tmp_path):
    """A repository whose env.py is one line, in the hub's cache."""
    commit = "0" * 40
    repository = tmp_path / "models--user--engram-env"
    (repository / "refs").mkdir(parents=True)
    (repository / "refs" / "main").write_text(commit)
    (repository / "snapshots" / commit).mkdir(parents=True)
    (repository / "snapshots" / commit / "env.py").write_text(
        "from engram.integrations.lerobot import make_env\n"
    )
    made = make_env(
        "user/engram-env", n_envs=2, trust_remote_code=True, hub_cache_dir=str(tmp_path)
    )
    env = made[TASK][0]
    obs, _ = env.reset(seed=[1, 2])
    assert env.observation_space.contains(obs)
    close_envs(made)


class Simple(Player):
    """Actions that follow from what is seen, and from the steps since the reset."""

    def select_action(self, batch, **_):
        self.seen.append(batch)
        light = batch["observation.images.wrist"].mean((1, 2, 3))
        wave = torch.sin(len(self.seen) * torch.arange(1, 8))
        return torch.tanh(light[:, None] * wave + batch["observation.state"][:, :1])


def test_a_policy_of_lerobot_is_evaluated_during_its_training(config):
    """It sees and does in engram's evaluation what it does in LeRobot's rollout."""
    policy = Simple()
    adapted = LeRobotPolicy(policy, lambda batch: batch, lambda action: action)
    policy.train()
    periodic = PeriodicEvaluation(TASK, every=10, episodes=3, num_envs=3, obs="rgb", seed=SEED)
    record = periodic(0, adapted)
    assert policy.training
    seen = policy.seen
    env = make_env(config, n_envs=3)[TASK][0]
    result = rollout(env, policy, seeds=[SEED, SEED + 1, SEED + 2], **pipelines(config))
    env.close()
    assert record["success"] == result["success"].any(1).float().mean()
    assert len(policy.seen) == len(seen) == 25
    for first, second in zip(policy.seen, seen):
        for name in ("observation.state", "observation.images.top"):
            np.testing.assert_array_equal(first[name], second[name])
        assert first["task"] == second["task"]
