"""Queries of environments: robot, cameras, drawn values."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import TASK

import engram


@pytest.mark.parametrize("obs_mode", ["none", "state", "rgb", "objects"])
def test_robot_state_in_every_observation_mode(obs_mode):
    env = engram.make_vec(TASK, 3, obs_mode=obs_mode, privileged=True)
    with pytest.raises(engram.BadStateError, match="first reset"):
        env.robot_state()
    env.reset(seed=4)
    for _ in range(4):
        info = env.step(env.act("random"))[4]
    robot = env.robot_state()
    shapes = {name: (array.shape, array.dtype.name) for name, array in robot.items()}
    assert shapes == {
        "qpos": ((3, 9), "float32"),
        "qvel": ((3, 9), "float32"),
        "tcp_pose": ((3, 7), "float32"),
    }
    proprio = env.envs[1].output("proprio")
    np.testing.assert_array_equal(robot["tcp_pose"][1, :3], proprio[:3])
    np.testing.assert_allclose(robot["qpos"][1, 7:].sum(), proprio[6], rtol=1e-6)
    kept = robot["qpos"].copy()
    env.step(env.act("random"))
    np.testing.assert_array_equal(robot["qpos"], kept)  # a copy
    assert "elapsed_steps" in info
    env.close()


def test_camera_matrices():
    env = engram.make_vec(TASK, 2, obs_mode="rgb", image_size=(160, 120))
    env.reset(seed=1)
    cameras = env.camera_params()
    assert list(cameras) == ["base_camera", "hand_camera"]
    for camera in cameras.values():
        extrinsic, pose, intrinsic = camera.values()
        assert list(camera) == ["extrinsic_cv", "cam2world_gl", "intrinsic_cv"]
        assert (extrinsic.shape, pose.shape, intrinsic.shape) == ((2, 3, 4), (2, 4, 4), (2, 3, 3))
        # 90 degrees in a picture of 120 rows.
        np.testing.assert_allclose(intrinsic[0], [[60, 0, 80], [0, 60, 60], [0, 0, 1]], atol=1e-4)
        # One is the other's inverse, but for the directions of y and z.
        flip = np.diag([1, -1, -1, 1]).astype(np.float32)
        product = extrinsic @ pose @ flip
        np.testing.assert_allclose(product, np.broadcast_to(np.eye(4)[:3], (2, 3, 4)), atol=1e-6)
    np.testing.assert_allclose(cameras["base_camera"]["cam2world_gl"][1, :3, 3], [0.3, 0, 0.6])
    assert env.camera_params(64)["base_camera"]["intrinsic_cv"][0, 0, 2] == 32
    env.close()


def test_the_tool_is_in_view_of_the_wrist_camera():
    """The point between the fingers is before the wrist camera, wherever the arm is."""
    env = engram.make_vec(TASK, 2)
    env.reset(seed=1)
    for _ in range(12):
        env.step(env.act("random"))
        tip = np.append(env.robot_state()["tcp_pose"][1, :3], 1)
        seen = env.camera_params()["hand_camera"]["extrinsic_cv"][1] @ tip
        np.testing.assert_allclose(seen, [0.020001, 0.046498, 0.0674], atol=5e-4)
    env.close()


def test_single_environments_return_rows():
    env = engram.make("TraceShapeSeqEasy-VLA-v0")
    env.reset(seed=2)
    assert env.robot_state()["tcp_pose"].shape == (7,)
    assert env.camera_params()["hand_camera"]["extrinsic_cv"].shape == (3, 4)
    drawn = env.drawn()
    assert drawn["shape_sequence"].shape == (5,)
    assert drawn["sequence_len"] == (drawn["shape_sequence"] >= 0).sum()
    env.close()


def test_drawn_values_have_names_and_types():
    batch = engram.make_vec(TASK, 4, pins={"cue_steps": 5})
    batch.reset(seed=3)
    drawn = batch.drawn()
    assert set(drawn) == {"cue_steps_per_env", "empty_steps_per_env"}
    assert [field["name"] for field in engram.describe(TASK)["drawn"]] == list(drawn)
    assert drawn["cue_steps_per_env"].dtype == np.int64
    assert drawn["cue_steps_per_env"].tolist() == [5] * 4
    batch.close()

    turning = engram.make_vec("RotateLenientPos-VLA-v0", 3)
    _, info = turning.reset(seed=3)
    assert turning.drawn()["target_angle"].dtype == np.float32
    assert "target_angle" not in info
    turning.close()

    taking = engram.make_vec("TakeItBack-VLA-v0", 3)
    taking.reset()
    assert taking.drawn() == {}
    taking.close()
