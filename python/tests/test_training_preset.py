"""The preset for training: what it is made of, and policies that take it to an evaluation."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ENDING_TASK, TASK
from wrapped_batches import N, make, values

import engram
from engram import wrappers


@pytest.mark.parametrize(("obs_mode", "rows"), [("state", "ScaleState"), ("objects", "ObjectRows")])
def test_the_preset_is_its_wrappers(obs_mode, rows):
    env = engram.make_vec(TASK, N, preset="train", obs_mode=obs_mode, threads=1, seed=3)
    by_hand = wrappers.train(
        engram.make_vec(TASK, N, obs_mode=obs_mode, threads=1, seed=3, terminate_on_success=True)
    )
    names, inner = [], env
    while inner is not inner.unwrapped:
        names.append(type(inner).__name__)
        inner = inner.env
    assert names == ["HeldReward", "PotentialReward", "TimeLeft", rows, "ScaleActions"]
    env.reset(), by_hand.reset()
    for _ in range(30):
        ours, theirs = env.step(env.act("oracle")), by_hand.step(by_hand.act("oracle"))
        for one, other in zip(ours[:4], theirs[:4]):
            np.testing.assert_array_equal(one, other)


def test_the_way_back_pays_in_the_preset():
    """Where the cube has to leave the target again, that costs nothing of what it has gained."""
    inner = make("TakeItBack-VLA-v0", terminate_on_success=True)
    env = wrappers.train(inner, gamma=1, bonus=0)
    env.reset(seed=1)
    total, there, back = np.zeros(N), np.full(N, np.nan), np.full(N, np.nan)
    for _ in range(60):
        _, reward, terminated, _, info = env.step(env.act("oracle"))
        total += np.where(np.isnan(back), reward, 0)
        arrived = np.isnan(there) & values(info, "goal_reached_status", terminated).astype(bool)
        there[arrived] = total[arrived]
        returned = np.isnan(back) & terminated
        back[returned] = total[returned]
    assert (back > there + 2).all()


@pytest.mark.parametrize(
    ("task", "place"),
    [
        (TASK, "reached"),
        ("ShellGameTouch-VLA-v0", 'info["is_obj_placed"]'),
        ("ShellGameColorLampTouch-VLA-v0", "is_obj_placed"),
    ],
)
def test_standing_still_pays_where_the_arm_has_to(task, place):
    envs = [
        wrappers.train(make(task, terminate_on_success=True), gamma=1, bonus=0, still=weight)
        for weight in (0, 2)
    ]
    names = list(envs[0].task_of(0)["reward_terms"])
    rng = np.random.default_rng(1)
    before, paid, alive = np.zeros(N), np.zeros(N, np.bool_), np.ones(N, np.bool_)
    for env in envs:
        env.reset(seed=1)
    for _ in range(60):
        noise = rng.normal(0, 0.1, (N, 7))  # so that the hand arrives before it stands still
        without, with_it = (env.step(env.act("oracle") + noise) for env in envs)
        alive &= ~without[2]
        terms = np.nan_to_num(envs[0].unwrapped._views["reward_dict"])
        potential = 2 * terms[:, names.index("static_reward")] * terms[:, names.index(place)]
        gained, expected = with_it[1] - without[1], potential - before
        np.testing.assert_allclose(gained[alive], expected[alive], atol=1e-5)
        before, paid = potential, paid | (alive & (potential > 0))
    assert paid.any()


def test_rewards_without_a_place_to_stand_still_stay_as_they_are():
    env = wrappers.train(make("TimedTransferEasy-VLA-v0", terminate_on_success=True), still=1)
    assert "static_reward" not in env.env.terms


def test_tasks_in_one_batch_are_wrapped_as_alone():
    """Rewards, ends and times; the rows of several tasks have other columns."""
    ids = [TASK, "InterceptSlow-VLA-v0", ENDING_TASK]
    options = {"threads": 1, "seed": 3, "preset": "train", "autoreset_mode": "SAME_STEP"}
    group = engram.make_vec(ids, 6, **options)
    alone = [engram.make_vec(id, 2, **options) for id in ids]
    group.reset()
    for env in alone:
        env.reset()
    for _ in range(62):
        steps = [env.step(env.act("oracle")) for env in alone]
        rows, reward, *_ = group.step(group.act("oracle"))
        np.testing.assert_array_equal(reward, np.concatenate([step[1] for step in steps]))
        np.testing.assert_array_equal(rows[:, -1], np.concatenate([s[0][:, -1] for s in steps]))


def test_parts_of_the_preset_can_be_left_out():
    parts = ("scale_actions", "scale_observations", "time_left", "potential", "bonus")
    env = wrappers.train(make(), **dict.fromkeys(parts, 0))
    assert type(env) is engram.VectorEnv
    assert type(wrappers.train(make(), smoothing=0.5, bonus=0).env.env) is wrappers.ScaleState


def test_a_wrapper_is_closed_with_its_batch():
    env = engram.make_vec(TASK, 2, preset="train", threads=1)
    assert (len(env), env.closed, env.spec.id) == (2, False, f"engram/{TASK}")
    assert repr(env).startswith("<HeldReward of <PotentialReward of <TimeLeft of ")
    env.close()
    assert env.closed
    assert env.unwrapped.closed


def test_images_keep_their_form():
    env = engram.make_vec(TASK, 2, preset="train", obs_mode="rgb", image_size=16, threads=1)
    rows, _ = env.reset(seed=1)
    assert rows["rgb"].shape == (2, 16, 16, 6)
    for _ in range(26):
        _, reward, *_ = env.step(env.act("oracle"))
    assert np.isfinite(reward).all()


def test_a_preset_works_in_the_background_and_with_views():
    env = engram.make_vec(TASK, N, preset="train", threads=1, seed=3, autoreset_mode="SAME_STEP")
    other = engram.make_vec(
        TASK, N, preset="train", threads=1, seed=3, autoreset_mode="SAME_STEP", copy=False
    )
    env.reset(), other.reset()
    for _ in range(30):
        other.step_async(other.act("oracle"))
        for one, two in zip(env.step(env.act("oracle"))[:4], other.step_wait()[:4]):
            np.testing.assert_array_equal(one, two)


@pytest.mark.parametrize("obs_mode", ["state", "objects"])
def test_an_evaluation_gives_a_policy_what_its_wrappers_did(obs_mode):
    """Rows and smoothed actions of an evaluation are those of the wrapped batch."""
    weights = np.random.default_rng(2)

    def made():
        batch = engram.make_vec(TASK, N, obs_mode=obs_mode, threads=1, seed=77)
        return wrappers.train(batch, smoothing=0.5)

    env = made()
    matrix = weights.normal(size=(env.single_observation_space.shape[0], 7)).astype(np.float32)
    seen: list[np.ndarray] = []

    def act(rows, begins):
        assert begins.all() == (len(seen) == 0)
        seen.append(rows)
        return np.tanh(rows @ matrix)

    policy = wrappers.WrappedPolicy(made(), act)
    engram.evaluate(policy, TASK, obs=obs_mode, episodes=N, num_envs=N, threads=1, seed=77)
    rows, _ = env.reset()
    for expected in seen:
        np.testing.assert_array_equal(rows, expected)
        rows = env.step(np.tanh(rows @ matrix))[0]
    assert len(seen) == 25


def test_an_evaluation_gives_a_policy_pictures():
    def made():
        return engram.make_vec(TASK, N, obs_mode="rgb", preset="train", threads=1, seed=77)

    seen: list[dict[str, np.ndarray]] = []

    def act(observation, begins):
        seen.append({name: part.copy() for name, part in observation.items()})
        return np.full((N, 7), 0.3)

    policy = wrappers.WrappedPolicy(made(), act)
    engram.evaluate(policy, TASK, obs="rgb", episodes=N, num_envs=N, threads=1, seed=77)
    env = made()
    observation, _ = env.reset()
    for expected in seen:
        assert set(expected) == set(observation) == {"rgb", "proprio"}
        for name in expected:
            np.testing.assert_array_equal(observation[name], expected[name])
        observation = env.step(np.full((N, 7), 0.3))[0]
    assert len(seen) == 25


def test_an_evaluation_without_an_observation_is_refused():
    env = make(TASK, obs_mode="rgb+state", image_size=16)
    policy = wrappers.WrappedPolicy(env, lambda rows, begins: np.zeros((N, 7)))
    with pytest.raises(engram.InvalidArgumentError, match="has no 'rgb'"):
        engram.evaluate(policy, TASK, obs="state", episodes=N, num_envs=N, threads=1)


def test_an_evaluation_of_other_size_is_refused():
    policy = wrappers.WrappedPolicy(make(TASK), lambda rows, begins: np.zeros((N, 7)))
    with pytest.raises(engram.InvalidArgumentError, match="num_envs=6 and threads=1 needed"):
        engram.evaluate(policy, TASK, obs="state", episodes=9, num_envs=9, threads=1)


def test_wrong_values_are_refused():
    env = make()
    wrong = {
        "preset: 'rl' given; allowed: train": lambda: engram.make_vec(TASK, preset="rl"),
        "scale: 0 given": lambda: wrappers.ScaleActions(env, 0),
        "smoothing: 1 given": lambda: wrappers.SmoothActions(env, 1),
        "gamma: 0 given": lambda: wrappers.PotentialReward(env, gamma=0),
        "weight: -1 given": lambda: wrappers.PotentialReward(env, weight=-1),
        "terms: 'd' given; allowed: .*reaching_reward": lambda: wrappers.PotentialReward(
            env, terms={"d": 1}
        ),
        "bonus: -1 given": lambda: wrappers.HeldReward(env, bonus=-1),
        "another observation mode given, 'objects' needed": lambda: wrappers.ObjectRows(env),
        "rows needed": lambda: wrappers.TimeLeft(make(obs_mode="rgb", image_size=16)),
        "env: int given, a batch of engram needed": lambda: wrappers.Wrapper(3),
        r"actions: shape \(7,\) given, \(6, 7\) needed": lambda: wrappers.ScaleActions(env).step(
            np.zeros(7)
        ),
    }
    for message, call in wrong.items():
        with pytest.raises(engram.InvalidArgumentError, match=message):
            call()
    with pytest.raises(engram.BadStateError, match="restore its batch"):
        wrappers.HeldReward(env).restore(b"")
