"""Gymnasium's own vector wrappers run on a batch."""

from __future__ import annotations

import gymnasium
import numpy as np
import pytest
from conftest import TASK

wrappers = gymnasium.wrappers.vector

MODES = ["NEXT_STEP", "SAME_STEP"]


def run(env, steps: int = 55):
    obs, _ = env.reset(seed=0)
    assert env.observation_space.contains(obs)
    for _ in range(steps):
        obs, reward, terminated, truncated, info = env.step(env.unwrapped.act("oracle"))
        yield obs, reward, terminated | truncated, info


@pytest.mark.parametrize("mode", MODES)
def test_record_episode_statistics(make, mode):
    env = wrappers.RecordEpisodeStatistics(make(autoreset_mode=mode))
    finished = 0
    for _, _, done, info in run(env):
        if done.any():
            finished += int(done.sum())
            ours = info["final_info"] if mode == "SAME_STEP" else info
            np.testing.assert_array_equal(info["episode"]["l"][done], np.full(done.sum(), 25))
            np.testing.assert_allclose(
                info["episode"]["r"][done], ours["episode_return"][done], rtol=1e-5
            )
    assert finished == 8


def test_normalize_observation_and_reward(make):
    env = wrappers.NormalizeReward(wrappers.NormalizeObservation(make(num_envs=16)))
    seen = [(obs.copy(), reward.copy()) for obs, reward, *_ in run(env)]
    late = np.concatenate([obs for obs, _ in seen[25:]])
    assert np.abs(late.mean(axis=0)).max() < 2
    assert np.isfinite(late).all()
    assert all(np.isfinite(reward).all() for _, reward in seen)


def test_normalize_observation_refuses_same_step(make):
    """As docs/learning.md says, which recommends that mode otherwise."""
    with pytest.raises(ValueError, match="NEXT_STEP or DISABLED"):
        wrappers.NormalizeObservation(make(autoreset_mode="SAME_STEP"))


@pytest.mark.parametrize("obs_mode", ["objects", "objects_dict"])
def test_objects_modes_through_gymnasium(obs_mode):
    env = gymnasium.make_vec(f"engram/{TASK}", num_envs=3, obs_mode=obs_mode, threads=1)
    env = wrappers.FlattenObservation(wrappers.RecordEpisodeStatistics(env))
    episodes = 0
    for obs, _, done, _ in run(env, 30):
        assert obs.shape == (3, 25 + 3 * 42)
        assert env.observation_space.contains(obs)
        episodes += int(done.sum())
    assert episodes == 3
    env.close()


def test_wrappers_do_not_disturb_the_simulation(make):
    plain, wrapped = make(), wrappers.NormalizeObservation(make())
    plain.reset(seed=0)
    wrapped.reset(seed=0)
    for _ in range(30):
        actions = plain.act("oracle")
        np.testing.assert_array_equal(plain.step(actions)[1], wrapped.step(actions)[1])


def test_clips_rescaling_and_flattening(make):
    env = wrappers.FlattenObservation(make(obs_mode="state_dict"))
    env = wrappers.RescaleAction(env, min_action=-2.0, max_action=2.0)
    env = wrappers.ClipReward(wrappers.ClipAction(env), 0.1, 0.2)
    obs, _ = env.reset(seed=0)
    assert obs.shape == (4, engram_state_dim())
    _, reward, *_ = env.step(np.full((4, 7), 5.0, np.float32))
    assert (reward >= 0.1).all()


def engram_state_dim() -> int:
    import engram

    return engram.describe(TASK)["state_dim"]


def test_dict_info_to_list(make):
    env = wrappers.DictInfoToList(make(autoreset_mode="SAME_STEP"))
    *_, info = env.reset(seed=0)
    assert len(info) == 4
    assert info[2]["elapsed_steps"] == 0
    for _ in range(25):
        *_, infos = env.step(env.unwrapped.act("oracle"))
    assert infos[1]["final_info"]["success_once"]


def test_record_video(make, tmp_path):
    pytest.importorskip("moviepy")
    env = make(render_size=32)
    env = wrappers.RecordVideo(env, str(tmp_path), episode_trigger=lambda n: n == 0)
    for _ in run(env, 30):
        pass
    env.close()
    assert list(tmp_path.glob("*.mp4"))


def test_numpy_to_torch(make):
    torch = pytest.importorskip("torch")
    env = wrappers.NumpyToTorch(make())
    obs, _ = env.reset(seed=0)
    assert isinstance(obs, torch.Tensor)
    obs, reward, *_ = env.step(torch.zeros(4, 7))
    assert reward.dtype == torch.float32


def test_vectorized_single_env_wrappers(make):
    env = wrappers.TransformObservation(
        make(), lambda obs: obs * 2, observation_space=make().observation_space
    )
    plain = make()
    np.testing.assert_array_equal(env.reset(seed=0)[0], plain.reset(seed=0)[0] * 2)
