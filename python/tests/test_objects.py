"""The observation modes "objects" and "objects_dict": shapes, names, spaces, episodes."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import TASK, assert_same, registered_ids

import engram
from engram.envs.spaces import take

WIDTHS = {
    "seen": 1,
    "position": 3,
    "orientation": 4,
    "size": 3,
    "color": 12,
    "shape": 9,
    "state": 1,
    "kind": 9,
}


def parts_of(env: engram.VectorEnv) -> list[dict]:
    return env.description["state_fields"]


def test_shapes_and_names(make):
    env = make(obs_mode="objects_dict", num_envs=3)
    obs, _ = env.reset(seed=1)
    assert list(obs) == ["agent", "objects"]
    assert {name: part.shape for name, part in obs["agent"].items()} == {
        "qpos": (3, 9),
        "qvel": (3, 9),
        "tcp_pose": (3, 7),
    }
    assert {name: part.shape for name, part in obs["objects"].items()} == {
        name: (3, 3, width) for name, width in WIDTHS.items()
    }
    assert all(part.dtype == np.float32 for part in obs["objects"].values())


def test_parts_have_the_same_widths_in_all_ids():
    """So one network fits all tasks, as docs/observations.md says."""
    for id in registered_ids():
        fields = engram.describe(id, obs_mode="objects_dict")["state_fields"]
        agent = {f["name"]: f["width"] for f in fields if not f["name"].startswith("object_")}
        expected = {"qpos": 9, "qvel": 9, "tcp_pose": 7}
        assert agent == expected | ({"task_cue": 1} if id.startswith("Rotate") else {}), id
        objects = [f for f in fields if f["name"].startswith("object_")]
        assert len(objects) % len(WIDTHS) == 0
        for field in objects:
            assert field["width"] == WIDTHS[field["name"].split("_", 2)[2]], (id, field)


def test_the_row_is_that_of_the_description(make):
    rows = make(obs_mode="objects", observe_time=True)
    named = make(obs_mode="objects_dict", observe_time=True)
    obs, _ = rows.reset(seed=4)
    parts, _ = named.reset(seed=4)
    assert obs.shape == (4, rows.description["state_dim"])
    for _ in range(12):
        for field in parts_of(rows):
            column = obs[:, field["offset"] : field["offset"] + field["width"]]
            if field["name"].startswith("object_"):
                _, number, name = field["name"].split("_", 2)
                np.testing.assert_array_equal(parts["objects"][name][:, int(number)], column)
            else:
                np.testing.assert_array_equal(parts["agent"][field["name"]], column)
        actions = rows.act("random")
        obs, *_ = rows.step(actions)
        parts, *_ = named.step(actions)


def test_parts_are_views_of_the_batch(make):
    env = make(obs_mode="objects_dict", copy=False, pins={"cue_steps": 1, "empty_steps": 1})
    obs, _ = env.reset()
    assert (obs["objects"]["seen"].sum(axis=(1, 2)) == 1).all()
    env.step(env.act("zero"))
    assert (obs["objects"]["seen"] == 0).all()
    env.step(env.act("zero"))
    assert (obs["objects"]["seen"] == 1).all()


def test_colors_have_the_names_of_the_description(make):
    env = make("RememberColor3-VLA-v0", obs_mode="objects_dict", pins={"target": 2}, num_envs=5)
    obs, _ = env.reset()
    names = next(f["names"] for f in parts_of(env) if f["name"] == "object_0_color")
    for i in range(5):
        shown = obs["objects"]["seen"][i, :, 0] == 1
        assert names[obs["objects"]["color"][i, shown][0].argmax()] == "blue"
        assert not obs["objects"]["color"][i, ~shown].any()


@pytest.mark.parametrize("id", registered_ids())
def test_observations_lie_in_their_space(make, id):
    rows = make(id, 2, obs_mode="objects")
    named = make(id, 2, obs_mode="objects_dict")
    obs, parts = rows.reset(seed=1)[0], named.reset(seed=1)[0]
    for _ in range(10):
        assert rows.observation_space.contains(obs)
        assert rows.single_observation_space.contains(obs[1])
        assert named.observation_space.contains(parts)
        assert named.single_observation_space.contains(take(parts, 1))
        actions = rows.act("random")
        obs, parts = rows.step(actions)[0], named.step(actions)[0]
    assert rows.single_observation_space.is_bounded("both")
    # The fields "seen" and "color" are 0 or 1.
    box = named.single_observation_space["objects"]["color"]
    assert (box.low == 0).all()
    assert (box.high == 1).all()


def test_time_is_observed_on_request(make):
    plain = make(obs_mode="objects_dict")
    timed = make(obs_mode="objects_dict", observe_time=True)
    assert "time" not in plain.single_observation_space["agent"].spaces
    obs, _ = timed.reset(seed=0)
    for step in range(25):
        np.testing.assert_allclose(obs["agent"]["time"], step / 25, rtol=1e-6)
        obs, *_ = timed.step(timed.act("zero"))


def test_only_rotate_tasks_observe_their_cue(make):
    assert "task_cue" not in make(obs_mode="objects_dict").single_observation_space["agent"].spaces
    env = make("RotateStrictPos-VLA-v0", obs_mode="objects_dict", num_envs=2, privileged=True)
    obs, info = env.reset(seed=5)
    np.testing.assert_allclose(
        obs["agent"]["task_cue"][:, 0] * np.pi, info["oracle_info"].reshape(2), rtol=1e-5
    )


@pytest.mark.parametrize("obs_mode", ["objects", "objects_dict"])
def test_final_observations_are_stored(make, obs_mode):
    options = {"obs_mode": obs_mode, "observe_time": True, "num_envs": 2}
    env = make(autoreset_mode="SAME_STEP", **options)
    other = make(autoreset_mode="DISABLED", **options)
    env.reset(seed=3)
    other.reset(seed=3)
    for _ in range(25):
        actions = other.act("random")
        obs, _, _, truncated, info = env.step(actions)
        last, *_ = other.step(actions)
    assert truncated.all()
    final = info["final_obs"]
    for i in range(2):
        assert_same(final[i], take(last, i))
    first = obs if obs_mode == "objects" else obs["agent"]["time"]
    assert (first[:, 25 if obs_mode == "objects" else 0] == 0).all()


@pytest.mark.parametrize("obs_mode", ["objects", "objects_dict"])
def test_a_batch_is_restored_with_what_it_observed(make, obs_mode):
    env = make(obs_mode=obs_mode)
    env.reset(seed=7)
    for _ in range(12):
        obs, *_ = env.step(env.act("random"))
    saved = env.save()
    actions = env.act("random")
    after, *_ = env.step(actions)
    other = make(obs_mode=obs_mode)
    other.reset(seed=100)
    assert_same(other.restore(saved)[0], obs)
    assert_same(other.step(actions)[0], after)


def test_a_single_environment_observes_the_same_as_a_batch(make):
    batch = make(obs_mode="objects_dict", num_envs=2)
    single = engram.make(TASK, obs_mode="objects_dict")
    obs, _ = batch.reset(seed=5)
    assert_same(single.reset(seed=6)[0], take(obs, 1))
    single.close()


def test_policies_are_evaluated_on_objects():
    rows = []

    def policy(observation):
        assert observation["rgb"] is None
        rows.append(observation["state"].copy())
        return np.zeros((len(observation["instruction"]), 1, 7), np.float32)

    result = engram.evaluate(policy, TASK, episodes=2, num_envs=1, threads=1, obs="objects")
    assert result["tasks"][0]["obs_mode"] == "objects"
    env = engram.make(TASK, obs_mode="objects")
    expected = [env.reset(seed=4242424242)[0].copy()]
    expected += [env.step(np.zeros(7, np.float32))[0].copy() for _ in range(24)]
    np.testing.assert_array_equal(np.concatenate(rows[:25]), expected)
    env.close()
    with pytest.raises(engram.Error, match="'rgb', 'state' or 'objects' allowed"):
        engram.evaluate(policy, TASK, episodes=1, obs="objects_dict")
