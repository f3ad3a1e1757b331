"""ManiSkillVectorEnv: resets by itself, metrics, final observations."""

from __future__ import annotations

import pytest

pytest.importorskip("torch")

import gymnasium as gym
import torch
from helpers import made, shapes

import engram
import engram.mikasa as mikasa

ID = "RememberColor3-VLA-v0"


def test_it_resets_environments_whose_episodes_ended():
    with made(ID, num_envs=3, max_episode_steps=5) as env:
        flat = mikasa.FlattenRGBDObservationWrapper(
            mikasa.StateOnlyTensorToDictWrapper(env), rgb=False, depth=False
        )
        batch = mikasa.ManiSkillVectorEnv(
            flat, "ignored", ignore_terminations=True, record_metrics=True
        )
        assert batch.base_env is batch.unwrapped is env.unwrapped
        assert batch._env is flat
        assert mikasa.find_max_episode_steps_value(batch._env) == 5
        assert batch.max_episode_steps == 5
        batch.reset(seed=1, options={})
        batch.step(torch.zeros(3, 7))
        batch.reset(options={"env_idx": torch.tensor([2])})
        total = torch.zeros(3)
        for step in range(4):
            observation, reward, terminated, truncated, info = batch.step(torch.zeros(3, 7))
            total += reward
            assert shapes(info["episode"]) == {
                "success_once": "bool (3,)", "return": "float32 (3,)", "episode_len": "int32 (3,)",
                "reward": "float32 (3,)", "success_at_end": "bool (3,)",
            }  # fmt: skip
            assert ("final_info" in info) == (step == 3)
        assert truncated.tolist() == [True, True, False]
        assert not terminated.any()
        for name in ("_final_info", "_final_observation", "_elapsed_steps"):
            assert torch.equal(info[name], truncated)
        assert info["elapsed_steps"].tolist() == [5, 5, 4]  # that of the ended step
        assert batch.base_env.elapsed_steps.tolist() == [0, 0, 4]
        episode = info["final_info"]["episode"]
        assert episode["episode_len"].tolist() == [5, 5, 4]
        torch.testing.assert_close(episode["return"][2], total[2])
        torch.testing.assert_close(episode["reward"], episode["return"] / episode["episode_len"])
        final = info["final_observation"]["state"]
        assert torch.equal(final[2], observation["state"][2])
        assert not torch.equal(final[0], observation["state"][0])
        for key in info["final_observation"]:  # like scripts
            info["final_observation"][key] = info["final_observation"][key][truncated]
        assert len(info["final_observation"]["state"]) == 2
        assert batch.returns.tolist()[:2] == [0, 0]
        *_, info = batch.step(torch.zeros(3, 7))
        assert info["episode"]["episode_len"].tolist() == [1, 1, 5]


def test_spaces_are_those_of_the_observations():
    with made(ID, num_envs=2, obs_mode="rgb") as env:
        batch = mikasa.ManiSkillVectorEnv(mikasa.apply_mikasa_vla_wrappers(env))
        observation, _ = batch.reset(seed=1)
        for key, space in batch.single_observation_space.items():
            assert space.contains(observation[key][0].numpy())
        assert batch.action_space.shape == (2, 7)
        assert batch.single_action_space.shape == (7,)


def test_terminations_end_episodes_unless_ignored():
    id = "ShellGameTouch-VLA-v0"
    oracle = engram.make_vec(
        id, 2, rules="original", autoreset_mode="DISABLED", freeze_cue=False, after_end="continue"
    )
    ends = {}
    for ignored in (False, True):
        with made(id, num_envs=2) as env:
            batch = mikasa.ManiSkillVectorEnv(env, ignore_terminations=ignored, auto_reset=False)
            oracle.reset(seed=1)
            batch.reset(seed=1)
            ended = torch.zeros(2, dtype=torch.bool)
            for _ in range(30):
                action = oracle.act("oracle")
                oracle.step(action)
                _, _, terminated, truncated, info = batch.step(action)
                if not ignored:
                    assert torch.equal(terminated, info["success"])
                ended |= terminated
            ends[ignored] = ended.tolist()
            assert truncated.all()
    assert ends == {False: [True, True], True: [False, False]}
    oracle.close()


def test_by_id_and_by_gymnasium():
    batch = mikasa.ManiSkillVectorEnv(ID, 2, obs_mode="state", threads=1)
    assert batch.reset(seed=1)[0].shape == (2, 35)
    batch.close()
    keywords = {"obs_mode": "state", "threads": 1}
    if int(gym.__version__.split(".")[0]) >= 1:
        batch = gym.make_vec(ID, num_envs=2, **keywords)
    else:
        batch = gym.make_vec(ID, num_envs=2, vectorization_mode="custom", vector_kwargs=keywords)
    assert batch.reset(seed=1)[0].shape == (2, 35)
    batch.close()


def test_videos(tmp_path):
    av = pytest.importorskip("av")
    with made(
        ID,
        num_envs=3,
        render_mode="rgb_array",
        max_episode_steps=4,
        human_render_camera_configs={"width": 64, "height": 48},
    ) as env:
        recorder = mikasa.RecordEpisode(env, tmp_path, save_trajectory=False, max_steps_per_video=4)
        batch = mikasa.ManiSkillVectorEnv(recorder, 3, ignore_terminations=True)
        _, info = batch.reset(seed=1)
        assert "reconfigure" in info
        for _ in range(9):
            batch.step(torch.zeros(3, 7))
        batch.close()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["0.mp4", "1.mp4", "2.mp4"]
    with av.open(str(tmp_path / "0.mp4")) as video:
        frames = [frame.to_ndarray(format="rgb24") for frame in video.decode(video=0)]
    assert len(frames) == 5
    assert frames[0].shape == (48, 3 * 64, 3)
    with made(ID, render_mode="rgb_array") as env:
        with pytest.raises(engram.InvalidArgumentError, match="save_trajectory"):
            mikasa.RecordEpisode(env, tmp_path, save_trajectory=True)
        with pytest.raises(engram.InvalidArgumentError, match="info_on_video"):
            mikasa.RecordEpisode(env, tmp_path, info_on_video=True)
