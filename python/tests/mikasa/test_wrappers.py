"""The original's wrappers: observations, frozen actions, overlays, the table by id."""

from __future__ import annotations

import math

import numpy as np
import pytest

pytest.importorskip("torch")

import torch
from helpers import as_arrays, made, shapes

import engram
import engram.mikasa as mikasa
from engram.mikasa import apply_wrappers, wrappers

ID = "RememberColor3-VLA-v0"
FROZEN = {
    f"{name}-VLA-v0"
    for name in (
        "ShellGameTouch", "ShellGamePush", "ShellGameShuffleTouch",
        "ShellGameShuffleColorLampTouch", "ShellGameColorLampTouch",
        *(f"{game}{what}{n}" for game in ("Remember", "FindImposter")
          for what, sizes in (("Color", "359"), ("Shape", "359")) for n in sizes),
        *(f"{game}ShapeAndColor{n}" for game in ("Remember", "FindImposter")
          for n in ("3x2", "3x3", "5x3")),
    )
}  # fmt: skip


def test_the_table():
    configs = mikasa.VLA_WRAPPER_CONFIGS
    assert tuple(configs) == mikasa.MIKASA_VLA_ENV_IDS
    assert set(configs) == {task["id"] for task in engram.list() if task["canonical"]}
    assert len(configs) == 90
    freezing = {id for id, config in configs.items() if config.curriculum_wrapper}
    assert freezing == FROZEN
    assert all(config.overlays for config in configs.values())
    assert not any(config.expected_control_mode for config in configs.values())
    chains = [
        name for name in vars(apply_wrappers) if name.endswith("_OVERLAYS") and name[0] != "_"
    ]
    assert len(chains) == 12


def test_ids_beyond_the_benchmark_have_chains_of_engrams_own():
    configs = mikasa.EXTENDED_WRAPPER_CONFIGS
    assert not set(configs) & set(mikasa.MIKASA_VLA_ENV_IDS)
    assert len(configs) == 7
    for id in configs:
        with made(id, obs_mode="rgb", render_mode="rgb_array") as env:
            wrapped = mikasa.apply_mikasa_vla_wrappers(env)
            observation, _ = wrapped.reset(seed=0)
            assert {"rgb", "proprio"} <= set(observation)
            assert wrapped.render().shape == (1, 512, 512, 3)
            assert wrapped.max_episode_steps == engram.describe(id)["horizon"]


def test_observations_of_policies():
    with made(ID, num_envs=2, obs_mode="rgb") as env:
        env = mikasa.apply_mikasa_vla_wrappers(env)
        observation, _ = env.reset(seed=1)
        assert shapes(observation) == {
            "proprio": "float32 (2, 7)", "rgb": "uint8 (2, 128, 128, 6)",
        }  # fmt: skip
        assert env.observation_space.contains(as_arrays(observation))
        spaces = env.unwrapped.single_observation_space
        assert {key: space.shape for key, space in spaces.items()} == {
            "proprio": (7,), "rgb": (128, 128, 6),
        }  # fmt: skip
        assert env.max_episode_steps == 25
        assert observation["rgb"].is_contiguous()
        env.step(torch.zeros(2, 7))


def test_observations_are_those_of_engram():
    rng = np.random.default_rng(0)
    own = engram.make_vec(
        ID, 2, obs_mode="rgb", rules="original", autoreset_mode="DISABLED", privileged=True
    )
    with made(ID, num_envs=2, obs_mode="rgb") as env:
        env = mikasa.apply_mikasa_vla_wrappers(env, include_overlays=False)
        seen, _ = env.reset(seed=9)
        expected, _ = own.reset(seed=9)
        for _ in range(8):
            np.testing.assert_array_equal(seen["rgb"].numpy(), expected["rgb"])
            turn = np.abs(np.abs(seen["proprio"][:, 3].numpy()) - math.pi) < 0.1
            compared = [0, 1, 2, 4, 5, 6] if turn.any() else list(range(7))
            np.testing.assert_allclose(
                seen["proprio"].numpy()[:, compared], expected["proprio"][:, compared], atol=2e-6
            )
            action = rng.uniform(-1, 1, (2, 7)).astype(np.float32)
            seen, reward, *_ = env.step(torch.from_numpy(action))
            expected, own_reward, *_ = own.step(action)
            np.testing.assert_array_equal(reward.numpy(), own_reward)
    own.close()


@pytest.mark.parametrize(
    ("id", "width"),
    [("RotateLenientPos-VLA-v0", 1), ("ShellGameColorLampTouch-VLA-v0", 0),
     ("TraceShapeSeqEasy-VLA-v0", 0)],
)  # fmt: skip
def test_only_rotate_has_a_cue_beside_images(id, width):
    with made(id, num_envs=2, obs_mode="rgb") as env:
        env = mikasa.apply_mikasa_vla_wrappers(env)
        observation, info = env.reset(seed=1)
        assert ("task_cue" in observation) == bool(width)
        assert "oracle_info" not in observation
        assert info["task_cue"] is not None


@pytest.mark.parametrize(
    ("id", "width"),
    [(ID, 35), ("RotateLenientPos-VLA-v0", 33 + 1), ("ShellGameColorLampTouch-VLA-v0", 30 + 1),
     ("TraceShapeSeqEasy-VLA-v0", 52 + 5)],
)  # fmt: skip
def test_inputs_of_state_policies(id, width):
    with made(id, num_envs=2, obs_mode="state") as env:
        env = mikasa.StateOnlyTensorToDictWrapper(env)
        env = mikasa.FlattenRGBDObservationWrapper(env, rgb=False, depth=False)
        observation, _ = env.reset(seed=1)
        agent = mikasa.AgentStateOnly(mikasa.ManiSkillVectorEnv(env))
        assert agent.actor_mean[0].in_features == width
        assert agent.get_action(observation, deterministic=True).shape == (2, 7)
        names = {name.split(".")[0] for name in agent.state_dict()}
        assert names == {"critic", "actor_mean", "actor_logstd"}


def test_other_flags_of_the_flat_observation():
    with made(ID, num_envs=2, obs_mode="rgb") as env:
        inner = mikasa.StateOnlyTensorToDictWrapper(env)
        joints = mikasa.FlattenRGBDObservationWrapper(inner, depth=False, state=False, joints=True)
        observation, _ = joints.reset(seed=1)
        raw, _ = inner.reset(seed=1)
        expected = torch.cat(
            [raw["extra"]["tcp_pose"], raw["agent"]["qpos"], raw["agent"]["qvel"]], 1
        )
        assert torch.equal(observation["proprio"], expected)
        state = mikasa.FlattenRGBDObservationWrapper(inner, depth=False, state=True, oracle=True)
        observation, _ = state.reset(seed=1)
        assert shapes(observation) == {
            "oracle_info": "uint8 (2, 1)", "state": "float32 (2, 25)",
            "rgb": "uint8 (2, 128, 128, 6)",
        }  # fmt: skip
        assert torch.equal(observation["state"], expected[:, [*range(7, 25), *range(7)]])
        agent = mikasa.Agent(state, sample_obs=observation)
        assert agent.get_action_and_value(observation)[0].shape == (2, 7)


def test_absent_values_are_not_sentinels():
    with made(ID, num_envs=2, obs_mode="state") as env:
        observation, _ = mikasa.StateOnlyTensorToDictWrapper(env).reset(seed=1)
        assert shapes(observation) == {
            "state": "float32 (2, 35)", "task_cue": "float32 (2, 1)", "oracle_info": "uint8 (2, 1)",
        }  # fmt: skip
        assert (observation["task_cue"] == 4242424242).all()


@pytest.mark.parametrize("kind", ["torch", "numpy", "one"])
def test_actions_are_frozen_while_the_cue_is_shown(kind):
    with made(ID, num_envs=3) as env:
        env = mikasa.CurriculumPhaseNoopActionWrapper(env)
        _, info = env.reset(seed=1)
        base = env.unwrapped
        until = base.cue_steps_per_env + base.empty_steps_per_env
        given = {
            "torch": torch.ones(3, 7), "numpy": np.ones((3, 7), np.float32), "one": torch.ones(7),
        }[kind]  # fmt: skip
        for step in range(12):
            passed = torch.as_tensor(np.broadcast_to(np.asarray(env.action(given)), (3, 7)))
            assert torch.equal(passed[:, 0] == 0, step < until)
            *_, info = env.step(given)
        assert info["elapsed_steps"].tolist() == [12] * 3
        assert (torch.as_tensor(given) == 1).all()


def test_frozen_joints_hold_their_pose():
    with made(ID, num_envs=2, control_mode="pd_joint_pos") as env:
        env = mikasa.CurriculumPhaseNoopActionWrapperPdJointPos(env)
        env.reset(seed=1)
        held = env.action(torch.zeros(2, 8))
        torch.testing.assert_close(held[:, :7], env.unwrapped.agent.robot.get_qpos()[:, :7])
        assert held[:, 7].tolist() == pytest.approx([1, 1])


@pytest.mark.parametrize("mode", ["pd_joint_pos", "pd_ee_delta_pose"])
def test_observations_of_policies_in_joint_space(mode):
    observations = []
    for joints in (False, True):
        with made(ID, num_envs=2, obs_mode="rgb", control_mode=mode) as env:
            env = mikasa.apply_mikasa_vla_wrappers(env, joint_proprio=joints)
            observation, _ = env.reset(seed=1)
            assert env.max_episode_steps == 25
            assert env.observation_space.contains(as_arrays(observation))
            start = env.unwrapped.agent.robot.get_qpos()
            env.step(torch.zeros(env.unwrapped._env.action_space.shape))
            observations.append(observation)
            moved = float((env.unwrapped.agent.robot.get_qpos() - start)[:, :7].abs().max())
            # Zeros are a pose in pd_joint_pos, and frozen actions zeros or the present pose.
            assert (moved > 0.02) == (mode == "pd_joint_pos" and not joints)
    usual, own = observations
    assert shapes(own) == {"proprio": "float32 (2, 8)", "rgb": "uint8 (2, 128, 128, 6)"}
    assert torch.equal(usual["rgb"], own["rgb"])
    assert torch.equal(own["proprio"][:, :7], start[:, :7])
    torch.testing.assert_close(own["proprio"][:, 7], start[:, 7] + start[:, 8])
    torch.testing.assert_close(own["proprio"][:, 7], usual["proprio"][:, 6])


def test_joints_of_other_widths():
    with made(ID, num_envs=2, obs_mode="rgb") as env:
        env = mikasa.ConvertJointsToQposGripperWidthWrapper(env)
        row = np.arange(50, dtype=np.float32).reshape(2, 25)
        assert env.observation({"proprio": row})["proprio"].tolist() == [
            [*range(7, 14), 14 + 15], [*range(32, 39), 39 + 40],
        ]  # fmt: skip
        for unchanged in ({"proprio": row[:, :8]}, {"rgb": row}, row):
            assert env.observation(unchanged) is unchanged
        with pytest.raises(engram.InvalidArgumentError, match="12 numbers given; 8, or at least"):
            env.observation({"proprio": row[:, :12]})


def test_without_a_cue_nothing_is_frozen():
    with made("TakeItBack-VLA-v0", num_envs=2) as env:
        env = mikasa.CurriculumPhaseNoopActionWrapper(env)
        env.reset(seed=1)
        action = torch.ones(2, 7)
        assert env.action(action) is action


def test_initial_zeros_and_dark_cameras():
    with made(ID, num_envs=2, obs_mode="rgb") as env:
        env = mikasa.CameraShutdownWrapper(env, n_initial_steps=2)
        env = mikasa.InitialZeroActionWrapper(env, n_initial_steps=2)
        env.reset(seed=1)
        sums = []
        for step in range(4):
            assert bool((env.action(torch.ones(2, 7)) == 0).all()) == (step < 2)
            observation, *_ = env.step(torch.ones(2, 7))
            sums.append(int(observation["sensor_data"]["hand_camera"]["rgb"].sum()))
        assert [one > 0 for one in sums] == [True, True, False, False]


@pytest.mark.parametrize(
    "id", ["ShellGameTouch-VLA-v0", "RememberColor3-VLA-v0", "RememberShape5-VLA-v0",
           "FindImposterShapeAndColor3x2-VLA-v0", "BunchOfColors3-VLA-v0", "TakeItBack-VLA-v0",
           "RotateStrictPos-VLA-v0", "BatteriesCheckerEasy-3-VLA-v0",
           "BlinkCountButtonPressEasy-VLA-v0", "TraceShapeEasy-VLA-v0", "TraceShapeSeqHard-VLA-v0",
           "TimedTransferEasy-VLA-v0", "GatherAndRecall3-VLA-v0"],
)  # fmt: skip
def test_overlays_draw_over_pictures_only(id, monkeypatch):
    monkeypatch.delenv("MIKASA_DISABLE_REWARD_OVERLAY", raising=False)
    with made(id, num_envs=2, obs_mode="state", render_mode="rgb_array") as env:
        plain = env
        for overlay in mikasa.VLA_WRAPPER_CONFIGS[id].overlays:
            env = overlay(env)
        env = mikasa.DebugRewardWrapper(env)
        env.reset(seed=1)
        for _ in range(3):
            observation = env.step(torch.zeros(2, 7))[0]
        drawn = env.render()
        bare = plain.render().numpy()
        assert isinstance(drawn, np.ndarray)
        assert drawn.shape == bare.shape
        assert drawn.dtype == np.uint8
        changed = (drawn != bare).any(-1).mean((1, 2))
        assert ((changed > 0.002) & (changed < 0.25)).all()
        assert isinstance(observation, torch.Tensor)


@pytest.mark.parametrize(
    ("id", "colors"),
    [("TraceShapeHard-VLA-v0", ([240, 210, 60], [80, 220, 80])),
     ("TraceShapeSeqEasy-VLA-v0", ([255, 255, 255],))],
)  # fmt: skip
def test_the_map_shows_contour_and_checkpoints(id, colors):
    with made(id, num_envs=1, render_mode="rgb_array") as env:
        env = mikasa.RenderTraceShapeDebugWrapper(env)
        env.reset(seed=3)
        base = env.unwrapped
        while id == "TraceShapeHard-VLA-v0" and not 0.2 < env.info["visit_fraction"] < 0.9:
            env.step(base._env.act("oracle"))
        picture = env.render()[0][130:290, 10:170].astype(int)
        points = base.checkpoints[0].reshape(-1, 12, 2)[0].numpy()
        ways = base.waypoints[0].reshape(-1, 64, 2)[0].numpy()
        middle, extent = (ways.max(0) + ways.min(0)) / 2, np.ptp(ways, axis=0).max()
        at = np.rint(80 - (points - middle) * 128 / extent).astype(int)
        seen = [picture[row, column].tolist() for row, column in at]
        assert {tuple(one) for one in seen} == {tuple(one) for one in colors}
        if id == "TraceShapeHard-VLA-v0":
            visited = env.info["checkpoint_visited"][0].tolist()
            assert [one == colors[1] for one in seen] == visited
        on_line = np.rint(80 - (ways - middle) * 128 / extent).astype(int)
        white = [(picture[r - 1 : r + 2, c - 1 : c + 2] > 200).all(-1).any() for r, c in on_line]
        assert sum(white) > 40


def test_the_reward_overlay_can_be_switched_off(monkeypatch):
    with made(ID, render_mode="rgb_array") as env:
        env.reset(seed=1)
        shown = mikasa.RenderRewardInfoWrapper(env)
        shown.reset(seed=1)
        plain = env.render().numpy()
        assert (shown.render() != plain).any()
        monkeypatch.setenv("MIKASA_DISABLE_REWARD_OVERLAY", "yes")
        assert (shown.render() == plain).all()


def test_attributes_pass_through_wrappers():
    with made(ID, num_envs=2, obs_mode="rgb") as env:
        env = mikasa.apply_mikasa_vla_wrappers(env)
        assert env.COLORS == 3
        assert env.device == torch.device("cpu")
        assert env.unwrapped is env.env.unwrapped


def test_ids_outside_the_table_are_refused_until_they_are_added(monkeypatch):
    id = "ShellGamePick-v0"  # of the RL half
    with made(id, obs_mode="rgb") as env:
        with pytest.raises(ValueError, match="RememberColor3-VLA-v0"):
            mikasa.apply_mikasa_vla_wrappers(env)
        config = mikasa.VLAWrapperConfig((), None, "pd_joint_pos")
        monkeypatch.setitem(mikasa.VLA_WRAPPER_CONFIGS, id, config)
        with pytest.warns(RuntimeWarning, match="pd_joint_pos"):
            mikasa.apply_mikasa_vla_wrappers(env)


def test_all_names_are_in_one_module():
    assert len([name for name in wrappers.__all__ if name.endswith("Wrapper")]) == 19
    for name in wrappers.__all__:
        assert getattr(mikasa, name) is getattr(wrappers, name)
