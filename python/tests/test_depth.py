"""Observation modes with depth and segmentation: shapes, spaces, interfaces, points."""

from __future__ import annotations

import gymnasium
import numpy as np
import pytest
from conftest import TASK
from transitions import end_of_episode

import engram
from engram.envs.spaces import ImageBox

MODES = {
    "rgb+depth": ["depth"],
    "rgb+segmentation": ["segmentation"],
    "rgb+depth+segmentation": ["depth", "segmentation"],
}


@pytest.mark.parametrize("mode", MODES)
def test_shapes_types_and_spaces(make, mode):
    env = make(obs_mode=mode, num_envs=3)
    plain = make(obs_mode="rgb", num_envs=3)
    obs, _ = env.reset(seed=2)
    rgb, _ = plain.reset(seed=2)
    for _ in range(6):
        assert list(obs) == ["rgb", "proprio", *MODES[mode]]
        assert list(env.single_observation_space) == list(obs)
        np.testing.assert_array_equal(obs["rgb"], rgb["rgb"])
        for name in MODES[mode]:
            assert (obs[name].dtype, obs[name].shape) == (np.int16, (3, 128, 128, 2))
        assert env.observation_space.contains(obs)
        actions = plain.act("random")
        rgb = plain.step(actions)[0]
        obs = env.step(actions)[0]
    names = env.description["segmentation_names"]
    assert plain.description["segmentation_names"] == []
    if "segmentation" in MODES[mode]:
        assert names[:3] == ["background", "table", "ground"]
        assert env.single_observation_space["segmentation"].high.max() == len(names) - 1
        assert obs["segmentation"].max() < len(names)
    else:
        assert names == []
        assert env.single_observation_space["depth"].high.max() == 32767


def test_a_single_environment_and_gymnasium_have_the_same(make):
    batch, _ = make(obs_mode="rgb+depth+segmentation", num_envs=1).reset(seed=3)
    for env in (
        engram.make(TASK, obs_mode="rgb+depth+segmentation"),
        gymnasium.make(f"engram/{TASK}", obs_mode="rgb+depth+segmentation"),
    ):
        obs, _ = env.reset(seed=3)
        assert env.observation_space.contains(obs)
        for name in ("depth", "segmentation"):
            np.testing.assert_array_equal(obs[name], batch[name][0])
        env.close()


def test_depth_becomes_points_of_the_table(make):
    env = make(obs_mode="rgb+depth+segmentation", num_envs=2)
    obs, _ = env.reset(seed=1)
    table = env.description["segmentation_names"].index("table")
    y, x = np.mgrid[0:128, 0:128] + 0.5
    for channel, camera in enumerate(env.camera_params().values()):
        for i in range(2):
            depth = obs["depth"][i, :, :, channel] / 1000.0
            rays = np.linalg.inv(camera["intrinsic_cv"][i]) @ [
                x.ravel(),
                y.ravel(),
                np.ones(x.size),
            ]
            seen = rays * depth.ravel()
            turn, shift = camera["extrinsic_cv"][i, :, :3], camera["extrinsic_cv"][i, :, 3:]
            points = turn.T @ (seen - shift)
            on_top = (obs["segmentation"][i, :, :, channel].ravel() == table) & (points[2] > -0.1)
            assert on_top.sum() > 1000
            assert np.abs(points[2, on_top]).max() < 0.0012  # it is seen half a millimetre lower


def test_last_pictures_of_an_episode(make):
    env = make(obs_mode="rgb+depth+segmentation", num_envs=1, autoreset_mode="SAME_STEP")
    twin = make(obs_mode="rgb+depth+segmentation", num_envs=1, autoreset_mode="DISABLED")
    final, last, obs = end_of_episode(env, twin)
    for name in ("depth", "segmentation"):
        np.testing.assert_array_equal(final[name], last[name][0])
        assert not np.array_equal(final[name], obs[name][0])


def test_spaces_of_whole_numbers():
    box = ImageBox((4, 3, 2), 1, np.int16, 5)
    plain = gymnasium.spaces.Box(0, 5, (4, 3, 2), np.int16, 1)
    assert box == plain
    assert repr(box) == repr(plain)
    sample = box.sample()
    np.testing.assert_array_equal(sample, plain.sample())
    assert box.contains(sample)
    assert not box.contains(sample + np.int16(6))
    assert not box.contains(sample - np.int16(6))
    assert box != ImageBox((4, 3, 2), 1, np.int16, 6)
    assert box != ImageBox((4, 3, 2))
    assert gymnasium.vector.utils.batch_space(box, 7) == ImageBox((7, 4, 3, 2), 1, np.int16, 5)
