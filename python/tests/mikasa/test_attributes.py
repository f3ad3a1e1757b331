"""Attributes and methods of the environment itself."""

from __future__ import annotations

import pytest

pytest.importorskip("torch")

import torch
from helpers import made, shapes

import engram
import engram.mikasa as mikasa

ID = "RememberColor3-VLA-v0"


def test_the_robot():
    for mode in ("state_dict", "rgb", "none"):
        with made(ID, num_envs=2, obs_mode=mode) as env:
            observation, _ = env.reset(seed=1)
            agent = env.unwrapped.agent
            assert shapes(agent.robot.get_qpos()) == shapes(agent.robot.get_qvel())
            assert shapes(agent.robot.get_qpos()) == "float32 (2, 9)"
            assert shapes(agent.tcp.pose.raw_pose) == "float32 (2, 7)"
            assert shapes(agent.tcp.pose.p) == "float32 (2, 3)"
            assert shapes(agent.robot.pose.q) == "float32 (2, 4)"
            assert agent.robot.pose.p[0].tolist() == pytest.approx([-0.615, 0, 0])
            if mode != "none":
                assert torch.equal(agent.robot.get_qpos(), observation["agent"]["qpos"])
                assert torch.equal(agent.tcp.pose.raw_pose, observation["extra"]["tcp_pose"])
            assert agent.is_static(0.2).all()
            for _ in range(3):
                env.step(torch.ones(2, 7))
            assert not agent.is_static(0.2).any()
            with pytest.raises(engram.UnavailableError, match="has no such information"):
                agent.is_grasping(None)
    with made("TimedTransferEasy-VLA-v0", num_envs=2) as env:
        assert shapes(env.unwrapped.agent.is_grasping("blue_cube")) == "bool (2,)"


def test_attributes_that_scripts_use():
    with made(ID, num_envs=2, obs_mode="rgb", reconfiguration_freq=3) as env:
        base = env.unwrapped
        assert (base.control_mode, base.obs_mode, base.reward_mode, base.num_envs) == (
            "pd_ee_delta_pose", "rgb", "normalized_dense", 2,
        )  # fmt: skip
        assert (base.control_freq, base.sim_freq, base.control_timestep) == (20, 100, 0.05)
        assert base.reconfiguration_freq == 3
        assert base.device == torch.device("cpu")
        assert base._init_raw_obs.keys() == base.observation_space.keys()
        env.reset(seed=1)
        info = base.evaluate()
        assert "elapsed_steps" not in info
        assert set(base.get_info()) == {"elapsed_steps", *info}
        assert torch.equal(base.oracle_info, info["oracle_info"])
        assert base.task_cue is None
        assert shapes(base.get_obs(info))["extra"] == {"tcp_pose": "float32 (2, 7)"}
        flags = [env.reset()[1]["reconfigure"] for _ in range(6)]
        assert flags == [False, False, True, False, False, True]
        assert env.reset(options={"reconfigure": True})[1]["reconfigure"]
        with pytest.raises(AttributeError, match="no attribute 'nothing'"):
            _ = base.nothing
        with pytest.raises(AttributeError, match="body of the original's scene"):
            _ = base.cubes


@pytest.mark.parametrize("mode", ["rgb", "state"])
def test_cameras_of_the_scene(mode):
    with made(ID, num_envs=2, obs_mode=mode, sensor_configs={"width": 40, "height": 30}) as env:
        observation, _ = env.reset(seed=1)
        scene = env.unwrapped.scene
        assert list(scene.sensors.keys()) == ["base_camera", "hand_camera"]
        for name, camera in scene.sensors.items():
            assert (camera.uid, camera.width, camera.height) == (name, 40, 30)
            params = camera.get_params()
            assert {key: tuple(value.shape) for key, value in params.items()} == {
                "extrinsic_cv": (2, 3, 4), "cam2world_gl": (2, 4, 4), "intrinsic_cv": (2, 3, 3),
            }  # fmt: skip
            if mode == "rgb":
                seen = observation["sensor_param"][name]
                assert all(torch.equal(params[key], seen[key]) for key in params)
        with pytest.raises(AttributeError, match=r"scene\.actors: .* it has sensors and num_envs"):
            _ = scene.actors
    with made(ID, robot_uids="panda") as env:
        assert type(env.unwrapped.agent).__name__ == "Panda"
        assert env.unwrapped.agent.uid == "panda"
        assert list(env.unwrapped.scene.sensors) == ["base_camera"]


def test_rewards_can_be_computed_again():
    with made(ID, num_envs=2) as env:
        env.reset(seed=1)
        observation, reward, *_, info = env.step(torch.zeros(2, 7))
        base = env.unwrapped
        given = {"obs": observation, "action": torch.zeros(2, 7), "info": info}
        assert torch.equal(base.get_reward(**given), reward)
        assert torch.equal(base.compute_normalized_dense_reward(**given), reward)
        torch.testing.assert_close(base.compute_dense_reward(**given), reward * 3)
        assert torch.equal(base.compute_sparse_reward(**given), info["success"])
    with (
        made(ID, reward_mode="sparse") as env,
        pytest.raises(engram.BadStateError, match="dense rewards are not computed"),
    ):
        env.unwrapped.compute_dense_reward(None, None, {})


def test_states_go_on_where_they_were():
    with made(ID, num_envs=2) as env:
        env.reset(seed=1)
        env.step(torch.ones(2, 7))
        base = env.unwrapped
        state, parts = base.get_state(), base.get_state_dict()
        first = env.step(torch.zeros(2, 7))[0]
        base.set_state(state)
        assert torch.equal(env.step(torch.zeros(2, 7))[0], first)
        base.set_state_dict(parts)
        assert torch.equal(env.step(torch.zeros(2, 7))[0], first)
        with pytest.raises(engram.InvalidArgumentError, match="actors"):
            base.set_state_dict({"actors": {}})


def test_results_are_copies():
    with made(ID, num_envs=2) as env:
        first, info = env.reset(seed=1)
        kept, steps = first.clone(), info["elapsed_steps"]
        env.step(torch.ones(2, 7))
        assert torch.equal(first, kept)
        assert steps.tolist() == [0, 0]


def test_without_gymnasium():
    env = mikasa.RememberColor3VLAEnv(num_envs=2, obs_mode="state", threads=1)
    env.reset(seed=1)
    for _ in range(30):
        *_, truncated, _ = env.step(torch.zeros(2, 8))
    assert not truncated.any()  # no time limit
    env.close()


def test_drawn_values():
    with made("TimedTransferEasy-VLA-v0", num_envs=3) as env:
        env.reset(seed=1)
        base = env.unwrapped
        assert shapes(base.signal_step) == "int64 (3,)"
        assert torch.equal(base.window_start, base.signal_step + 95)
        assert torch.equal(base.window_end, base.signal_step + 105)
    with made("SeqOfColors3-VLA-v0", num_envs=3) as env:
        env.reset(seed=1)
        assert (env.unwrapped.cue_steps_per_env % 3 == 0).all()
    with made("BlinkCountButtonPressEasy-VLA-v0", num_envs=3) as env:
        env.reset(seed=1)
        assert (env.unwrapped.empty_steps_per_env == 0).all()
        assert shapes(env.unwrapped.target_blinks) == "int64 (3,)"
