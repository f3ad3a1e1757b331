from __future__ import annotations

import copy
import warnings

import numpy as np
import pytest
from conftest import ENDING_TASK, TASK

pytest.importorskip("stable_baselines3")

from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecMonitor, VecNormalize

import engram
from engram.integrations.periodic import PeriodicEvaluation
from engram.integrations.sb3 import EvaluationCallback, Sb3VecEnv


@pytest.fixture
def env():
    made = Sb3VecEnv(TASK, num_envs=4, threads=2, render_size=16)
    yield made
    made.close()


def test_ppo_trains(env):
    model = PPO("MlpPolicy", VecNormalize(env), n_steps=50, batch_size=50, n_epochs=1, device="cpu")
    model.learn(4 * 50 * 2)
    assert model.num_timesteps == 400
    assert len(model.ep_info_buffer) == 16  # every episode was counted
    assert all(info["l"] == 25 for info in model.ep_info_buffer)


def test_ppo_trains_from_pixels():
    env = Sb3VecEnv(TASK, num_envs=2, obs_mode="rgb", image_size=36, threads=2)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model = PPO("MultiInputPolicy", env, n_steps=8, batch_size=8, n_epochs=1, device="cpu")
    model.learn(16)
    env.close()


@pytest.mark.parametrize(
    ("policy", "images_only"), [("MultiInputLstmPolicy", False), ("CnnLstmPolicy", True)]
)
def test_recurrent_ppo_trains_from_pixels(policy, images_only):
    contrib = pytest.importorskip("sb3_contrib")
    options = {"obs_mode": "rgb", "image_size": 36, "images_only": images_only, "threads": 2}
    env = Sb3VecEnv(TASK, num_envs=2, **options)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model = contrib.RecurrentPPO(
            policy, env, n_steps=26, batch_size=26, n_epochs=1, device="cpu"
        )
    model.learn(52)
    assert model.num_timesteps == 52
    env.close()


def test_the_preset_for_training():
    env = Sb3VecEnv(ENDING_TASK, num_envs=4, preset="train", threads=1, seed=5)
    inner = engram.make_vec(ENDING_TASK, 4, threads=1, seed=5, autoreset_mode="SAME_STEP")
    assert env.action_space.high[0] == pytest.approx(1 / 0.3)
    rows, _ = env.reset(), inner.reset()
    assert env.observation_space.contains(rows[0])
    ended = 0
    for _ in range(30):
        rows, rewards, dones, infos = env.step(env.batch.act("oracle"))
        plain = inner.step(inner.act("oracle"))
        np.testing.assert_array_equal(dones, plain[2] | plain[3])
        for i in np.flatnonzero(dones):
            assert infos[i]["terminal_observation"].shape == rows[i].shape
            final = plain[4]["final_info"]
            # The sum of rounded rewards, and the rounded sum.
            returned = pytest.approx(float(final["episode_return"][i]), rel=1e-6)
            assert infos[i]["episode"]["r"] == returned
            assert rewards[i] > 1 > plain[1][i] - 1e-6  # the rest of the horizon
            ended += 1
    assert ended >= 4
    env.close()


def test_images_only():
    env = Sb3VecEnv(TASK, num_envs=2, obs_mode="rgb", image_size=16, images_only=True)
    assert env.observation_space.contains(env.reset()[0])
    for _ in range(25):
        obs, _, dones, infos = env.step(env.batch.act("zero"))
    assert obs.shape == (2, 16, 16, 6)
    assert dones.all()
    assert infos[1]["terminal_observation"].shape == (16, 16, 6)
    env.close()
    with pytest.raises(engram.InvalidArgumentError, match="images_only: obs_mode='state' given"):
        Sb3VecEnv(TASK, images_only=True)


def test_mistakes_and_names():
    with pytest.raises(TypeError, match=r"^Sb3VecEnv\(\) .*'num_env'. Did you mean"):
        Sb3VecEnv(TASK, num_env=2)
    env = Sb3VecEnv(TASK, num_envs=2)
    assert "Sb3VecEnv" in repr(env)
    assert "num_envs=2" in repr(env)
    env.close()


def test_results_are_copies_and_infos_separate_truncation(env):
    first = env.reset()
    kept = first.copy()
    for _ in range(25):
        obs, reward, dones, infos = env.step(env.batch.act("oracle"))
    np.testing.assert_array_equal(first, kept)
    assert reward.dtype == np.float32
    assert dones.all()
    for i, info in enumerate(infos):
        assert info["TimeLimit.truncated"] is True
        assert info["is_success"] is True
        assert info["episode"]["l"] == 25
        assert info["terminal_observation"].shape == obs[i].shape
        assert not np.array_equal(info["terminal_observation"], obs[i])


def test_success_that_ends_an_episode_is_no_time_limit():
    env = Sb3VecEnv(ENDING_TASK, num_envs=2)
    env.reset()
    seen = []
    for _ in range(60):
        _, _, dones, infos = env.step(env.batch.act("oracle"))
        seen += [infos[i]["TimeLimit.truncated"] for i in np.flatnonzero(dones)]
    assert seen
    assert False in seen
    env.close()


def test_seeds_and_options_take_effect_at_the_next_reset(env):
    env.seed(7)
    env.set_options({"pins": {"target": 2}})
    obs = env.reset()
    own = engram.make_vec(TASK, 4, pins={"target": 2})
    np.testing.assert_array_equal(obs, own.reset(seed=7)[0])
    assert not np.array_equal(env.reset(), obs)
    own.close()


def test_attributes_and_methods(env):
    env.reset()
    assert env.get_attr("task") == [TASK] * 4
    assert len(env.get_attr("language_instruction", [0, 2])) == 2
    env.set_attr("note", 3, indices=1)
    assert env.get_attr("note", 1) == [3]
    assert env.env_method("output", "elapsed_steps", indices=[0]) == [0]
    assert env.env_is_wrapped(VecMonitor) == [False] * 4
    assert [image.shape for image in env.get_images()] == [(16, 16, 3)] * 4


@pytest.mark.parametrize("options", [{"preset": "train"}, {"obs_mode": "rgb", "image_size": 128}])
def test_an_agent_is_evaluated_in_training_as_it_is_trained(options, monkeypatch):
    """It sees what a batch shows it that plays the same episodes."""
    env = Sb3VecEnv(TASK, num_envs=2, threads=1, seed=5, **options)
    name = "MultiInputPolicy" if "obs_mode" in options else "MlpPolicy"
    model = PPO(name, env, n_steps=25, batch_size=50, n_epochs=1, device="cpu", seed=0)
    obs = options.get("obs_mode", "state")
    evaluation = PeriodicEvaluation(TASK, every=1000, episodes=2, num_envs=2, obs=obs, seed=7)
    seen, predict = [], model.predict

    def recorded(observation, *rest, **options):
        seen.append(copy.deepcopy(observation))
        return predict(observation, *rest, **options)

    monkeypatch.setattr(model, "predict", recorded)
    model.learn(50, callback=EvaluationCallback(evaluation))
    (record,) = evaluation.records
    assert (record["step"], record["episodes"]) == (0, 2)
    assert len(seen) == 25
    fresh = PPO(name, env, n_steps=25, batch_size=50, n_epochs=1, device="cpu", seed=0)
    other = Sb3VecEnv(TASK, num_envs=2, threads=1, **options)
    other._seeds = [7, 8]
    shown = other.reset()
    for given in seen:
        for key in shown if isinstance(shown, dict) else [...]:
            np.testing.assert_array_equal(given[key], shown[key])
        shown = other.step(fresh.predict(shown, deterministic=True)[0])[0]
    env.close()
    other.close()


def test_an_evaluation_needs_its_own_vec_env():
    env = VecMonitor(Sb3VecEnv(TASK, num_envs=2, threads=1))
    evaluation = PeriodicEvaluation(TASK, every=100, episodes=2, num_envs=2, obs="state")
    with pytest.raises(engram.InvalidArgumentError, match=r"an Sb3VecEnv needed"):
        PPO("MlpPolicy", "CartPole-v1", n_steps=8, batch_size=8, device="cpu").learn(
            8, callback=EvaluationCallback(evaluation)
        )
    model = PPO("MlpPolicy", env, n_steps=8, batch_size=8, device="cpu")
    model.learn(8, callback=EvaluationCallback(evaluation))
    assert len(evaluation.records) == 1
    env.close()
