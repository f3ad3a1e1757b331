"""gym.make's keywords: served, ignored with one warning, refused with a reason."""

from __future__ import annotations

import warnings

import pytest

pytest.importorskip("torch")

import gymnasium as gym
import torch
from helpers import made, shapes

import engram.mikasa
from engram.mikasa import _keywords

ID = "RememberColor3-VLA-v0"

SERVED = {
    "num_envs": 3,
    "obs_mode": "state_dict",
    "control_mode": "pd_joint_pos",
    "reward_mode": "dense",
    "render_mode": "all",
    "sim_backend": "auto",
    "reconfiguration_freq": 2,
    "max_episode_steps": 7,
    "robot_uids": "panda_wristcam",
    "robot_init_qpos_noise": 0.0,
    "sensor_configs": {"width": 64, "height": 32},
    "human_render_camera_configs": {"render_camera": {"width": 64, "height": 64}},
    "enable_shadow": True,
    "rules": "reference",
}
IGNORED = {
    "sim_backend": "gpu",
    "render_backend": "gpu",
    "shader_dir": "default",
    "viewer_camera_configs": {"width": 100},
    "enhanced_determinism": True,
}
REFUSED = {
    "sim_config": {"sim_freq": 200},
    "parallel_in_single_scene": True,
    "obs_mode": "pointcloud",
    "render_mode": "human",
    "control_mode": "pd_nothing",
    "reward_mode": "shaped",
    "robot_uids": "fetch",
    "sensor_configs": {"fov": 1.0},
    "human_render_camera_configs": {"render_camera": {"pose": 1}},
    "sim_backend": "tpu",
    "num_envs": 0,
}


@pytest.mark.parametrize("name", SERVED)
def test_served(name):
    with warnings.catch_warnings(), made(ID, **{name: SERVED[name]}) as env:
        warnings.simplefilter("error")
        env.reset(seed=1)


@pytest.mark.parametrize("name", IGNORED)
def test_ignored_with_one_warning(name):
    _keywords._warned.clear()
    with pytest.warns(UserWarning, match=name), made(ID, **{name: IGNORED[name]}):
        pass
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with made(ID, **{name: IGNORED[name]}):
            pass


@pytest.mark.parametrize("name", REFUSED)
def test_refused_with_a_reason(name):
    with pytest.raises((engram.Error, NotImplementedError), match=r"given|no control") as error:
        gym.make(ID, **{name: REFUSED[name]})
    assert name.replace("_", " ") in str(error.value).replace("_", " ")


def test_unknown_ones_are_type_errors():
    with pytest.raises(TypeError, match="Did you mean 'num_envs'"):
        gym.make(ID, num_env=3)
    with pytest.raises(TypeError, match="angle_threshold"):  # Rotate has it alone
        gym.make(ID, angle_threshold=0.1)
    with made("RotateLenientPos-VLA-v0", angle_threshold=0.2) as env:
        assert env.unwrapped.angle_threshold == 0.2
    with pytest.raises(engram.InvalidArgumentError, match="blink_color"):
        gym.make("BlinkCountButtonPressEasy-VLA-v0", blink_color=[1, 0, 0, 1])


def test_original_cpu_backend_has_one_environment():
    with pytest.raises(engram.InvalidArgumentError, match="num_envs 2"):
        gym.make(ID, num_envs=2, sim_backend="cpu")


def test_defaults():
    with made(ID, control_mode=None) as env:
        base = env.unwrapped
        assert base.control_mode == "pd_joint_delta_pos"
        assert base.obs_mode == "state"
        assert base.reward_mode == "normalized_dense"
        assert base._env.description["rules"] == "original"
        assert base.reconfiguration_freq == 0
        with pytest.raises(RuntimeError, match="render_mode is None"):
            env.render()
    with made("ShellGameTouch-VLA-v0") as env:
        assert env.unwrapped.reconfiguration_freq == 1


@pytest.mark.parametrize("steps", [7, 40])
def test_the_users_horizon_in_both_directions(steps):
    with made(ID, num_envs=2, max_episode_steps=steps) as env:
        assert env.spec.max_episode_steps == steps
        assert engram.mikasa.find_max_episode_steps_value(env) == steps
        env.reset(seed=1)
        for step in range(1, steps + 3):  # nothing stops after the end
            *_, truncated, info = env.step(torch.zeros(2, 7))
            assert truncated.tolist() == [step >= steps] * 2
        assert info["elapsed_steps"].tolist() == [steps + 2] * 2


def test_reward_modes():
    rewards = {}
    for mode in ("normalized_dense", "dense", "sparse", "none"):
        with made(ID, num_envs=2, reward_mode=mode) as env:
            env.reset(seed=1)
            for _ in range(4):
                _, rewards[mode], *_, info = env.step(torch.full((2, 7), 0.3))
            if mode == "sparse":
                assert torch.equal(rewards[mode], info["success"])
    assert shapes(rewards["sparse"]) == "bool (2,)"
    assert rewards["none"].tolist() == [0, 0]
    torch.testing.assert_close(rewards["dense"], rewards["normalized_dense"] * 3)


@pytest.mark.parametrize(
    ("mode", "shape"),
    [("rgb_array", (512, 512)), ("sensors", (128, 256)), ("all", (512, 640)),
     ("cameras", (128, 256))],
)  # fmt: skip
def test_pictures(mode, shape):
    with made(ID, num_envs=2, render_mode=mode) as env:
        env.reset(seed=1)
        assert shapes(env.render()) == f"uint8 {(2, *shape, 3)}"
        assert env.render_mode == mode
        assert mode in env.unwrapped.metadata["render_modes"]
    if mode == "cameras":
        with made(ID, num_envs=2, obs_mode="rgb", render_mode=mode) as env:
            data = env.reset(seed=1)[0]["sensor_data"].values()
            assert torch.equal(env.render(), torch.cat([one["rgb"] for one in data], dim=2))


def test_the_plain_panda_sees_with_one_camera_and_lacks_the_others_mass():
    with made(ID, obs_mode="rgb", robot_uids="panda") as env:
        observation = env.reset(seed=1)[0]
        assert list(observation["sensor_data"]) == ["base_camera"]
        assert list(observation["sensor_param"]) == ["base_camera"]
        assert env.unwrapped.robot_uids == env.unwrapped.agent.uid == "panda"
    motions = []
    for robot in ("panda_wristcam", "panda"):
        with warnings.catch_warnings(), made(ID, robot_uids=robot) as env:
            warnings.simplefilter("error")
            env.reset(seed=1)
            for _ in range(10):
                env.step(torch.tensor([0, 0, 0, 1.0, 0, 0, 0]))
            motions.append(env.unwrapped.agent.robot.get_qpos())
            changed = env.unwrapped._env.description["changed"]
            assert changed.get("robot_uids", "panda_wristcam") == robot
    difference = (motions[0] - motions[1]).abs().max()
    assert 1e-5 < difference < 0.05  # the hand is 0.564 kg lighter


@pytest.mark.parametrize("control_mode", ["pd_joint_delta_pos", "pd_ee_delta_pose"])
def test_a_step_without_an_action_goes_on(control_mode):
    with made(ID, num_envs=2, control_mode=control_mode) as env:
        env.reset(seed=1)
        start = env.unwrapped.agent.robot.get_qpos()
        *_, info = env.step(None)
        assert info["elapsed_steps"].tolist() == [1, 1]
        torch.testing.assert_close(env.unwrapped.agent.robot.get_qpos(), start, atol=1e-4, rtol=0)
        action = torch.zeros(2, env.unwrapped.single_action_space.shape[0])
        action[:, 1] = 0.5
        action[:, -1] = 1
        env.step(action)
        before = env.unwrapped.agent.robot.get_qpos()
        _, reward, terminated, truncated, info = env.step(None)
        after = env.unwrapped.agent.robot.get_qpos()
        # The arm goes on towards the targets; zeros would hold it where it is.
        assert (
            (after - start)[:, :7].norm(dim=1) > 1.2 * (before - start)[:, :7].norm(dim=1)
        ).all()
        torch.testing.assert_close(after[:, 7:], start[:, 7:], atol=1e-3, rtol=0)
        assert info["elapsed_steps"].tolist() == [3, 3]
        assert reward.shape == (2,)
        assert not (terminated | truncated).any()


def test_wrappers_pass_a_step_without_an_action_on():
    with made(ID, obs_mode="rgb") as env:
        env = engram.mikasa.apply_mikasa_vla_wrappers(env)
        env.reset(seed=1)
        for _ in range(3):
            observation, *_, info = env.step(None)
        assert info["elapsed_steps"].tolist() == [3]
        assert observation["proprio"].shape == (1, 7)


def test_actions():
    with made(ID, num_envs=2) as env:
        env.reset(seed=1)
        first = env.step(torch.full((7,), 0.5))[0]
        env.reset(seed=1)
        assert torch.equal(first, env.step(torch.full((2, 7), 0.5).double())[0])
        env.reset(seed=1)
        assert torch.equal(first, env.step([[0.5] * 7] * 2)[0])
        for wrong in (torch.zeros(3, 7), torch.full((2, 7), float("nan"))):
            with pytest.raises(engram.InvalidArgumentError):
                env.step(wrong)


def test_a_reset_of_some():
    with made(ID, num_envs=3) as env:
        env.reset(seed=1)
        for _ in range(4):
            before = env.step(torch.zeros(3, 7))[0]
        after, info = env.reset(options={"env_idx": torch.tensor([1])})
        assert info["elapsed_steps"].tolist() == [4, 0, 4]
        assert torch.equal(before[[0, 2]], after[[0, 2]])
        assert not torch.equal(before[1], after[1])


def test_seeds():
    with made(ID, num_envs=2) as env:
        first, _ = env.reset(seed=4)
        for same in ([4, 5], torch.tensor([4, 5])):
            assert torch.equal(env.reset(seed=same)[0], first)
        assert not torch.equal(env.reset()[0], first)


def test_rules_come_from_the_keyword_then_the_environment_and_are_said_once(monkeypatch, capsys):
    monkeypatch.delenv("ENGRAM_RULES", raising=False)
    monkeypatch.setattr(_keywords, "_warned", set())
    for _ in range(2):
        with made(ID) as env:
            assert env.unwrapped._chosen.rules == "original"
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "rules of the original's code" in said
    assert "ENGRAM_RULES=reference" in said
    monkeypatch.setattr(_keywords, "_warned", set())
    monkeypatch.setenv("ENGRAM_RULES", "reference")
    with made(ID) as env:
        assert env.unwrapped._chosen.rules == "reference"
    with made(ID, rules="original") as env:
        assert env.unwrapped._chosen.rules == "original"
    assert capsys.readouterr().err == ""
    monkeypatch.setenv("ENGRAM_RULES", "referense")
    with pytest.raises(engram.InvalidArgumentError, match=r"ENGRAM_RULES.*reference"):
        gym.make(ID)
