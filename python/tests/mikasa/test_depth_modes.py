"""Depth and segmentation beside the pictures of `engram.mikasa`."""

from __future__ import annotations

import gymnasium as gym
import numpy as np
import pytest

pytest.importorskip("torch")

import torch
from helpers import as_arrays

import engram
from engram import mikasa

ID = "RememberColor3-VLA-v0"
MODES = {
    "rgbd": ("rgb", "depth"),
    "rgb+depth": ("rgb", "depth"),
    "rgb+segmentation": ("rgb", "segmentation"),
    "rgb+depth+segmentation": ("rgb", "depth", "segmentation"),
}


@pytest.mark.parametrize("mode", MODES)
def test_cameras_have_the_images_of_the_mode(mode):
    env = gym.make(ID, num_envs=3, obs_mode=mode)
    own = engram.make_vec(ID, 3, obs_mode=mode.replace("rgbd", "rgb+depth"), rules="original")
    observation, _ = env.reset(seed=7)
    expected, _ = own.reset(seed=7)
    for i, camera in enumerate(("base_camera", "hand_camera")):
        data = observation["sensor_data"][camera]
        assert tuple(data) == MODES[mode]
        for name, picture in data.items():
            channels = 3 if name == "rgb" else 1
            assert picture.shape == (3, 128, 128, channels)
            assert picture.dtype == (torch.uint8 if name == "rgb" else torch.int16)
            part = expected[name][..., i * channels : (i + 1) * channels]
            np.testing.assert_array_equal(picture.numpy(), part)
    assert env.observation_space.contains(as_arrays(observation))
    own.close()
    env.close()


def test_depth_is_the_distance_along_the_camera_in_millimetres():
    env = gym.make(ID, num_envs=1, obs_mode="rgb+depth")
    observation, _ = env.reset(seed=1)
    camera = {k: v[0].numpy() for k, v in observation["sensor_param"]["base_camera"].items()}
    depth = observation["sensor_data"]["base_camera"]["depth"][0, ..., 0].numpy() / 1000.0
    rows, columns = np.mgrid[:128, :128] + 0.5
    pixels = np.stack([columns * depth, rows * depth, depth], -1)
    seen = np.linalg.solve(camera["intrinsic_cv"], pixels.reshape(-1, 3).T)
    turn, shift = camera["extrinsic_cv"][:, :3], camera["extrinsic_cv"][:, 3:]
    world = (turn.T @ (seen - shift)).T.reshape(128, 128, 3)
    # Most of the lower half shows the table, whose top is at z = 0.
    assert np.median(np.abs(world[100:, :, 2])) < 0.002
    env.close()


def test_flat_observations_have_depth_behind_the_colours_of_each_camera():
    env = mikasa.FlattenRGBDObservationWrapper(
        gym.make(ID, num_envs=2, obs_mode="rgbd"), state=False, joints=True
    )
    observation, _ = env.reset(seed=1)
    raw = env.unwrapped.get_obs()["sensor_data"]
    assert observation["rgbd"].shape == (2, 128, 128, 8)
    parts = [raw[c][k] for c in ("base_camera", "hand_camera") for k in ("rgb", "depth")]
    assert torch.equal(observation["rgbd"], torch.cat(parts, -1))
    env.close()


def test_the_canonical_chain_leaves_depth_out():
    env = mikasa.apply_mikasa_vla_wrappers(gym.make(ID, num_envs=2, obs_mode="rgbd"))
    observation, _ = env.reset(seed=1)
    assert sorted(observation) == ["proprio", "rgb"]
    assert observation["rgb"].shape == (2, 128, 128, 6)
    env.close()
