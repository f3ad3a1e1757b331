"""Batches, data sets and evaluations under MuJoCo's physics."""

from __future__ import annotations

import json
import subprocess

import numpy as np
import pytest
from conftest import TASK, assert_same
from demonstrations import COMMAND

import engram
from engram.datasets import find_folders
from engram.datasets.__main__ import main
from engram.datasets.card import collect_command
from engram.play.episode_spec import EpisodeSpec

MUJOCO = {"physics": "mujoco"}


def played(env, steps, policy="oracle"):
    """All that a batch shows while it steps."""
    return [env.reset(seed=3), *(env.step(env.act(policy)) for _ in range(steps))]


def test_the_oracle_succeeds_and_moves_a_little_differently(make):
    env = make(num_envs=6, autoreset_mode="DISABLED", **MUJOCO)
    usual = make(num_envs=6, autoreset_mode="DISABLED")
    shown, shown_usually = (played(one, env.description["horizon"]) for one in (env, usual))
    observation, first_info = shown[0]
    assert observation.shape == shown_usually[0][0].shape
    np.testing.assert_array_equal(observation, shown_usually[0][0])  # the same draws
    assert list(first_info) == list(shown_usually[0][1])
    last = shown[-1]
    assert last[4]["success_once"].all()
    assert not np.array_equal(last[0], shown_usually[-1][0])
    assert env.unstable_count == 0


@pytest.mark.parametrize("id", [TASK, "ShellGamePush-VLA-v0"])
def test_bits_do_not_depend_on_threads(make, id):
    one, three = (make(id, 7, threads=threads, **MUJOCO) for threads in (1, 3))
    for first, second in zip(played(one, 30), played(three, 30)):
        for a, b in zip(first, second):
            assert_same(a, b)


def test_a_snapshot_continues_bit_for_bit(make):
    env = make(num_envs=2, **MUJOCO)
    played(env, 8)
    saved, whole = env.save(0), env.save()
    expected = [env.step(env.act("oracle")) for _ in range(5)]
    env.restore(whole)
    for step in expected:
        for a, b in zip(step, env.step(env.act("oracle"))):
            assert_same(a, b)
    other = make(num_envs=3, **MUJOCO)
    other.reset(seed=9)
    other.restore(saved, 2)
    for step in expected:
        observation = other.step(other.act("oracle"))[0]
        np.testing.assert_array_equal(observation[2], step[0][0])


def test_snapshots_are_refused_by_the_other_physics(make):
    env, usual = make(**MUJOCO), make()
    for one, other in ((env, usual), (usual, env)):
        one.reset(seed=1)
        other.reset(seed=1)
        with pytest.raises(engram.InvalidArgumentError, match="physics=mujoco"):
            other.restore(one.save(0), 0)
    with pytest.raises(engram.InvalidArgumentError, match="physics"):
        make(physics="bullet")


def test_mujoco_state_is_of_this_moment_and_read_only(make):
    env = make(num_envs=3, **MUJOCO)
    with pytest.raises(engram.BadStateError, match="reset"):
        env.mujoco(0)
    played(env, 6)
    robot = env.robot_state()
    for index in range(3):
        state = env.mujoco(index)
        assert state.time == pytest.approx(0.3)
        np.testing.assert_array_equal(state.qpos[:9].astype(np.float32), robot["qpos"][index])
        np.testing.assert_array_equal(state.qvel[:9].astype(np.float32), robot["qvel"][index])
        assert state.xpos.shape == (len(state.body_names), 3)
        assert state.xquat.shape == (len(state.body_names), 4)
        assert state.mocap_pos.shape == (state.mocap_quat.shape[0], 3)
        assert (state.act.shape, state.ctrl.shape) == ((0,), (9,))
        fingers = state.xpos[
            [state.body_names.index(f"{side}finger") for side in ("left", "right")]
        ]
        assert np.linalg.norm(fingers.mean(axis=0) - robot["tcp_pose"][index, :3]) < 0.06
        assert len(state.joint_names) == 9 + (len(state.qpos) - 9) // 7
    with pytest.raises(ValueError, match="read-only"):
        state.qpos[0] = 1
    kept = state.qpos.copy()
    env.step(env.act("oracle"))
    np.testing.assert_array_equal(state.qpos, kept)
    assert not np.array_equal(env.mujoco(2).qpos, kept)
    with pytest.raises(engram.InvalidArgumentError, match="3"):
        env.mujoco(3)


def test_mujoco_state_of_one_environment():
    with engram.make(TASK, **MUJOCO) as env:
        env.reset(seed=2)
        assert env.mujoco().time == 0
    with engram.make(TASK) as env:
        env.reset(seed=2)
        with pytest.raises(engram.InvalidArgumentError, match="physics 'mujoco' needed"):
            env.mujoco()


def still(observation):
    return np.zeros((len(observation["instruction"]), 7), np.float32)


def test_evaluations_name_their_physics():
    options = {"episodes": 2, "obs": "state"}
    usual = engram.evaluate(still, TASK, **options)
    result = engram.evaluate(still, TASK, physics="mujoco", **options)
    assert "physics" not in usual["tasks"][0]
    assert result["tasks"][0]["physics"] == "mujoco"
    assert result["tasks"][0]["mujoco_version"]
    with pytest.raises(engram.InvalidArgumentError, match="allow physics"):
        engram.compare(usual, result)
    assert engram.compare(usual, result, allow=["physics"])["b"]["physics"] == "mujoco"
    probed = engram.probe(still, TASK, probes=["twins"], physics="mujoco", **options)
    assert probed["settings"]["physics"] == "mujoco"
    with pytest.raises(engram.InvalidArgumentError, match="physics"):
        engram.evaluate(still, TASK, physics="other", **options)


@pytest.fixture(scope="module")
def collected(tmp_path_factory):
    folder = tmp_path_factory.mktemp("mujoco")
    command = [*COMMAND, "collect", TASK, "--episodes=2", "--physics=mujoco", "--out", folder]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return folder


def test_demonstrations_are_played_again_under_their_physics(collected, capsys):
    assert main(["replay", str(collected), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)[0]["equal"]
    (found,) = find_folders(collected)
    assert found.metadata["engram"]["physics"] == "mujoco"
    assert "--physics mujoco" in collect_command(found)


def test_episodes_to_play_have_a_physics():
    spec = EpisodeSpec(TASK, 3, physics="mujoco")
    assert not spec.is_default  # its seed and actions are those of another physics
    assert spec.batch_key != EpisodeSpec(TASK, 3).batch_key
    own, other = EpisodeSpec(TASK, 3).make_batch(), spec.make_batch()
    spec.reset(own)
    spec.reset(other)
    with pytest.raises(engram.InvalidArgumentError, match="physics=mujoco"):
        own.restore(other.save())
    own.close()
    other.close()
