"""Wrappers for training: their equations, in all modes of automatic resets."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import TASK
from wrapped_batches import N, make, modes, play, values

import engram
from engram import wrappers
from engram.envs.compat import GYMNASIUM_1

# --- default off ---


def test_without_a_preset_there_is_no_wrapper():
    assert type(make()) is engram.VectorEnv


@modes
def test_the_batch_inside_is_untouched(mode):
    plain, inner = make(mode=mode), make(mode=mode)
    env = wrappers.TimeLeft(
        wrappers.HeldReward(wrappers.PotentialReward(wrappers.ScaleState(inner)))
    )
    plain.reset(seed=5), env.reset(seed=5)
    for _ in range(40):
        actions = plain.act("oracle")
        np.testing.assert_array_equal(actions, env.act("oracle"))
        _, reward, terminated, truncated, _ = plain.step(actions)
        _, _, wrapped_terminated, wrapped_truncated, info = env.step(actions)
        np.testing.assert_array_equal(info["benchmark_reward"], reward)
        np.testing.assert_array_equal(wrapped_terminated, terminated)
        np.testing.assert_array_equal(wrapped_truncated, truncated)
        assert plain.save() == inner.save()


# --- actions ---


def test_actions_are_scaled_and_clipped():
    plain, env = make(), wrappers.ScaleActions(make(), (0.5, 0.5, 0.5, 0.1, 0.1, 0.1, 1))
    np.testing.assert_allclose(env.single_action_space.high, [2, 2, 2, 10, 10, 10, 1])
    assert env.action_space.shape == (N, 7)
    plain.reset(seed=1), env.reset(seed=1)
    for step in range(12):
        actions = np.full((N, 7), 0.4 * step, np.float32)
        scaled = np.clip(actions * np.float32([0.5, 0.5, 0.5, 0.1, 0.1, 0.1, 1]), -1, 1)
        np.testing.assert_array_equal(env.step(actions)[0], plain.step(scaled)[0])


def test_scripted_actions_go_through_the_scale():
    plain, env = make(), wrappers.ScaleActions(make(), 0.25)
    plain.reset(seed=1), env.reset(seed=1)
    np.testing.assert_array_equal(4 * plain.act("oracle"), env.act("oracle"))


@modes
def test_actions_are_smoothed_from_zero_in_every_episode(mode):
    plain, env = make(TASK, mode), wrappers.SmoothActions(make(TASK, mode), 0.75)
    plain.reset(seed=1), env.reset(seed=1)
    past, begins = np.zeros((N, 7), np.float32), np.zeros(N, bool)
    rng = np.random.default_rng(1)
    for _ in range(60):
        actions = rng.uniform(-1, 1, (N, 7)).astype(np.float32)
        past = (1 - 0.75) * actions + 0.75 * past
        rows, _, terminated, truncated, _ = plain.step(past)
        np.testing.assert_array_equal(env.step(actions)[0], rows)
        ended = terminated | truncated
        if mode == "DISABLED" and ended.any():
            for one in (plain, env):
                one.reset(options={"reset_mask": ended})
        past[begins if mode == "NEXT_STEP" else ended] = 0
        begins = ended


def test_scripted_actions_are_reached_through_smoothing():
    plain, env = make(), wrappers.SmoothActions(make(), 0.5)
    plain.reset(seed=1), env.reset(seed=1)
    for _ in range(10):
        actions = plain.act("oracle")
        np.testing.assert_allclose(
            env.step(env.act("oracle"))[0], plain.step(actions)[0], atol=1e-4
        )


# --- rewards ---


@modes
def test_the_reward_is_a_difference_of_potentials(mode):
    env = wrappers.PotentialReward(make(mode=mode), gamma=0.9, weight=2)
    before = np.zeros(N)
    for reward, ended, benchmark, _, _, idle in play(env):
        potential = np.where(idle, 0, 2 * np.clip(benchmark, 0, 1))
        np.testing.assert_allclose(reward, np.where(idle, 0, 0.9 * potential - before), atol=1e-6)
        before = np.where(ended, 0, potential)


def test_terms_of_the_reward_count_in_the_potential():
    inner = make("InterceptSlow-VLA-v0", privileged=True, max_episode_steps=20)
    terms = {"tcp_to_hit_pose_dist": 3, "place_reward": 2}
    env = wrappers.PotentialReward(inner, 0.9, weight=0, terms=terms)
    env.reset()
    before = np.zeros(N)
    for _ in range(45):
        _, reward, terminated, truncated, info = env.step(env.act("oracle"))
        ended = terminated | truncated
        place, distance = values(info, "reward_dict", ended)[:, 2:].T
        potential = np.nan_to_num(3 * np.clip(1 - distance / 0.5, 0, 1) + 2 * np.clip(place, 0, 1))
        np.testing.assert_allclose(reward, 0.9 * potential - before, atol=1e-6)
        before = np.where(ended, 0, potential)
    assert potential.max() > 1


def test_terms_count_by_stages():
    inner = make("TakeItBack-VLA-v0", privileged=True, terminate_on_success=True)
    names = inner.task_of(0)["reward_terms"]
    flag, place, back = map(
        names.index, ("goal_reached_status", "place_in_goal_reward", "tcp_pull_dist")
    )
    terms = {"place_in_goal_reward": 2, "tcp_pull_dist": 3}
    env = wrappers.PotentialReward(
        inner,
        0.9,
        weight=0,
        terms=terms,
        until={"place_in_goal_reward": "goal_reached_status"},
        since={"tcp_pull_dist": "goal_reached_status"},
    )
    env.reset()
    before, stages = np.zeros(N), set()
    for _ in range(45):
        _, reward, terminated, truncated, info = env.step(env.act("oracle"))
        ended = terminated | truncated
        told = values(info, "reward_dict", ended)
        over = np.nan_to_num(told[:, flag]) == 1
        stages |= set(over)
        first = np.where(over, 1, np.clip(np.nan_to_num(told[:, place]), 0, 1))
        second = np.where(over, np.clip(1 - told[:, back] / 0.5, 0, 1), 0)
        potential = 2 * first + 3 * second
        np.testing.assert_allclose(reward, 0.9 * potential - before, atol=1e-6)
        before = np.where(ended, 0, potential)
    assert stages == {False, True}


@pytest.mark.parametrize("name", ["until", "since"])
def test_stages_need_terms_of_the_task(name):
    pair = {"tcp_to_obj_dist": "goal_reached_status"}
    with pytest.raises(engram.InvalidArgumentError, match=f"^{name}: 'goal_reached_status' given"):
        wrappers.PotentialReward(make(), **{name: pair})


def test_standing_still_pays_nothing_and_success_most():
    """Where the task's own reward pays in every step for being still (TASK, while it lasts)."""
    returns = {}
    for policy in ("zero", "oracle"):
        env = wrappers.train(make(TASK, terminate_on_success=True), gamma=0.99)
        env.reset(seed=9)
        total, alive = np.zeros(N), np.ones(N, bool)
        for step in range(24):
            _, reward, terminated, truncated, info = env.step(env.act(policy))
            if policy == "zero" and step > 14:  # all objects are there
                assert (reward < 0).all()
                assert (info["benchmark_reward"] > 0.1).all()
            total += alive * 0.99**step * reward
            alive &= ~(terminated | truncated)
        returns[policy] = total
    assert (returns["oracle"] > 2 * returns["zero"]).all()


def test_a_failed_episode_has_no_potential():
    env = wrappers.PotentialReward(make("GatherAndRecall1-VLA-v0", max_episode_steps=200), gamma=1)
    env.reset(seed=1)
    total = np.zeros(N)
    failed = np.zeros(N, bool)
    for _ in range(190):
        _, reward, terminated, _, info = env.step(env.act("blind"))
        total += np.where(failed, 0, reward)
        now = terminated & ~values(info, "success", terminated) & ~failed
        np.testing.assert_allclose(total[now], 0, atol=1e-5)
        failed |= terminated
    assert failed.any()


@modes
@pytest.mark.parametrize("gamma", [0.9, 1.0])
def test_success_pays_the_rest_of_the_horizon(mode, gamma):
    env = wrappers.HeldReward(make(mode=mode), gamma=gamma, bonus=2)
    paid = 0
    for reward, _, benchmark, success, elapsed, idle in play(env):
        rest = np.array([sum(gamma**k for k in range(30 - t + 1)) for t in elapsed])
        expected = np.where(success & ~idle, benchmark + 2 * rest, benchmark)
        np.testing.assert_allclose(reward, np.where(idle, 0, expected), rtol=1e-6)
        paid += np.count_nonzero(success & ~idle)
    assert paid >= N


def test_an_early_end_loses_no_return():
    """The bonus is what a step with success pays in an episode that goes on to the horizon."""
    ends = wrappers.HeldReward(make(mode="DISABLED", reward_mode="none"), gamma=1)
    total = sum(reward for reward, *_ in play(ends, 30))
    onward = make(mode="DISABLED", terminate_on_success=False)
    held = np.zeros(N)
    onward.reset()
    for _ in range(30):
        info = onward.step(onward.act("oracle"))[4]
        held += info["success_once"]
    np.testing.assert_array_equal(total, held)


def test_the_bonus_is_paid_once():
    env = wrappers.HeldReward(make(mode="DISABLED", terminate_on_success=False), gamma=1)
    succeeded = np.zeros(N, bool)
    for reward, _, _, success, _, _ in play(env, 30):
        assert (reward[succeeded] == 0).all()
        succeeded |= success
    assert succeeded.all()


# --- observations ---


def part(env, row: np.ndarray, name: str) -> np.ndarray:
    field = next(field for field in env.fields if field["name"] == name)
    return row[..., field["offset"] : field["offset"] + field["width"]]


def test_a_state_has_fixed_scales():
    plain, env = make("InterceptSlow-VLA-v0"), wrappers.ScaleState(make("InterceptSlow-VLA-v0"))
    state, scaled = plain.reset(seed=2)[0], env.reset(seed=2)[0]
    named = {
        f["name"]: state[:, f["offset"] :][:, : f["width"]]
        for f in plain.description["state_fields"]
    }
    tcp = named["tcp_pose"][:, :3]
    expected = {
        "qvel": named["qvel"],
        "qpos": (named["qpos"] - wrappers.observations.REST) / ([0.5] * 7 + [0.04] * 2),
        "tcp_pose": np.hstack([(tcp - [-0.0707, 0, 0.318]) / 0.1, named["tcp_pose"][:, 3:]]),
        "goal_pos": np.hstack([(named["goal_pos"] - tcp) / 0.1, np.ones((N, 1))]),
        "ball_pose": np.hstack(
            [(named["ball_pose"][:, :3] - tcp) / 0.1, named["ball_pose"][:, 3:], np.ones((N, 1))]
        ),
        "ball_linear_vel": named["ball_linear_vel"] / 0.5,
        "ball_angular_vel": named["ball_angular_vel"],
        "tcp_to_ball_pos": np.hstack([named["tcp_to_ball_pos"] / 0.1, np.ones((N, 1))]),
    }
    for name, value in expected.items():
        np.testing.assert_allclose(part(env, scaled, name), np.clip(value, -10, 10), atol=1e-5)
    assert env.observation_space.contains(scaled)
    assert sum(field["width"] for field in env.fields) == env.single_observation_space.shape[0]


def test_hidden_things_are_zeros():
    env = wrappers.ScaleState(make())
    rows, _ = env.reset(seed=2)
    assert not part(env, rows, "obj_pose").any()  # the cup is hidden during the cue
    for _ in range(10):
        rows = env.step(env.act("oracle"))[0]
    assert (part(env, rows, "obj_pose")[:, -1] == 1).all()


def test_exclusive_positions_are_one():
    env = wrappers.ScaleState(make(TASK, privileged=True))
    env.reset(seed=2)
    for _ in range(12):
        rows, *_, info = env.step(env.act("oracle"))
    expected = np.hstack([info["obj_to_goal_pos"] / 0.1, np.ones((N, 1))])
    np.testing.assert_allclose(part(env, rows, "goal_pose"), expected, atol=1e-4)


@pytest.mark.parametrize("wrapper", [wrappers.ScaleState, wrappers.ObjectRows, wrappers.TimeLeft])
def test_last_observations_are_those_of_episodes_that_are_held(wrapper):
    obs_mode = "objects" if wrapper is wrappers.ObjectRows else "state"
    held = wrapper(make(TASK, "DISABLED" if GYMNASIUM_1 else "SAME_STEP", obs_mode=obs_mode))
    env = wrapper(make(TASK, obs_mode=obs_mode))
    held.reset(seed=4), env.reset(seed=4)
    for _ in range(25):
        rows = held.step(held.act("oracle"))[0]
        next_rows, _, _, truncated, info = env.step(env.act("oracle"))
    assert truncated.all()
    if GYMNASIUM_1:
        np.testing.assert_array_equal(np.stack(info["final_obs"]), rows)
    assert next_rows.shape == (N, *env.single_observation_space.shape)


def test_objects_keep_their_columns():
    plain = make(TASK, obs_mode="objects_dict")
    env = wrappers.ObjectRows(make(TASK, obs_mode="objects"))
    plain.reset(seed=2), env.reset(seed=2)
    for _ in range(12):
        objects = plain.step(plain.act("oracle"))[0]
        rows = env.step(env.act("oracle"))[0]
    colors = [part(env, rows, f"object_{i}_color").argmax(-1) for i in range(3)]
    assert [set(color) for color in colors] == [{0}, {1}, {2}]  # red, green, blue in every row
    assert len(set(objects["objects"]["color"].argmax(-1)[:, 0])) > 1  # shuffled inside
    tcp = 0.5 * objects["agent"]["tcp_pose"][:, :3]
    which = objects["objects"]["color"].argmax(-1).argsort(-1)
    position = np.take_along_axis(objects["objects"]["position"], which[..., None], 1)
    for i in range(3):
        expected = (0.5 * position[:, i] - tcp) / 0.1
        np.testing.assert_allclose(part(env, rows, f"object_{i}_position"), expected, atol=1e-4)


def test_equal_objects_are_ordered_from_left_to_right():
    env = wrappers.ObjectRows(make("ShellGameTouch-VLA-v0", obs_mode="objects"))
    rows, _ = env.reset(seed=2)
    seen = np.stack([part(env, rows, f"object_{i}_seen")[:, 0] for i in range(4)], 1)
    assert (seen == [1, 0, 0, 0]).all()  # the ball, first though it has any token
    for _ in range(6):
        rows = env.step(env.act("zero"))[0]
    y = np.stack([part(env, rows, f"object_{i}_position")[:, 1] for i in range(3)], 1)
    assert (np.diff(y, axis=1) > 0).all()


@pytest.mark.parametrize("rows", ["state", "objects"])
def test_rows_beside_pictures_are_scaled_the_same(rows):
    alone, both = (
        wrappers.train(make(TASK, obs_mode=mode, image_size=16)) for mode in (rows, f"rgb+{rows}")
    )
    assert both.fields == alone.fields
    expected, seen = alone.reset()[0], both.reset()[0]
    for _ in range(30):
        np.testing.assert_array_equal(seen[rows], expected)
        assert both.observation_space.contains(seen)
        expected, *_, last = alone.step(alone.act("oracle"))
        seen, *_, info = both.step(both.act("oracle"))
        if GYMNASIUM_1 and "final_obs" in info:
            for one, other in zip(info["final_obs"], last["final_obs"]):
                np.testing.assert_array_equal(one[rows], other)
                assert one["rgb"].shape == (16, 16, 6)


@modes
def test_time_that_is_left(mode):
    env = wrappers.TimeLeft(make(TASK, mode))
    rows, _ = env.reset(seed=1)
    np.testing.assert_array_equal(rows[:, -1], 1)
    for step in range(1, 30):
        rows, *_, info = env.step(env.act("zero"))
        elapsed = info["elapsed_steps"]
        np.testing.assert_allclose(rows[:, -1], (25 - elapsed) / 25, rtol=1e-6)
        if step == 25 and mode == "SAME_STEP":
            assert [row[-1] for row in info["final_obs"]] == [0] * N
    assert env.observation_space.contains(rows)
