"""Observations of which only the needed part is made."""

from __future__ import annotations

import pytest

pytest.importorskip("torch")

import torch
from helpers import made

import engram.mikasa as mikasa
from engram.mikasa._observing import Wanted

IDS = [
    "RememberColor3-VLA-v0",
    "RotateLenientPos-VLA-v0",
    "ShellGameColorLampTouch-VLA-v0",
    "TraceShapeSeqEasy-VLA-v0",
]


class Watching(mikasa.StateOnlyTensorToDictWrapper):
    """A user's wrapper, which may need everything."""

    def observation(self, observation):
        """Keeps what it sees."""
        self.seen = dict(observation)
        return super().observation(observation)


def wrapped(env, first):
    """apply_mikasa_vla_wrappers with another first wrapper."""
    env = mikasa.CurriculumPhaseNoopActionWrapper(first(env))
    env = mikasa.RenderStepInfoWrapper(env)
    env = mikasa.FlattenRGBDObservationWrapper(env, depth=False, state=False, joints=True)
    return mikasa.ConvertJointsToEEFXyzRpyGripperWrapper(env)


def same(one, other):
    """Nested dicts and tuples with the same keys in the same order, values and types."""
    if isinstance(one, dict):
        return list(one) == list(other) and all(same(one[key], other[key]) for key in one)
    if isinstance(one, tuple):
        return all(map(same, one, other))
    if isinstance(one, torch.Tensor):
        return one.dtype == other.dtype and torch.equal(one.nan_to_num(), other.nan_to_num())
    return one == other


@pytest.mark.parametrize("id", IDS)
def test_the_short_way_is_the_long_way(id):
    keywords = {"num_envs": 3, "obs_mode": "rgb", "max_episode_steps": 8}
    with made(id, **keywords) as one, made(id, **keywords) as other:
        short = wrapped(one, mikasa.StateOnlyTensorToDictWrapper)
        long = wrapped(other, Watching)
        assert short._source is one.unwrapped._observations
        assert long._source is None
        assert same(short.reset(seed=5), long.reset(seed=5))
        for step in range(12):
            action = torch.rand(3, 7) * 2 - 1
            assert same(short.step(action), long.step(action))
            if step == 6:
                some = {"env_idx": torch.tensor([1])}
                assert same(short.reset(options=some), long.reset(options=some))
        assert short.observation_space == long.observation_space


def test_user_wrappers_get_complete_observations():
    with made(IDS[0], num_envs=2, obs_mode="rgb") as env:
        chain = wrapped(env, Watching)
        chain.reset(seed=1)
        chain.step(torch.zeros(2, 7))
        watching = chain.env.env.env.env
        assert set(watching.seen) == {"agent", "extra", "sensor_param", "sensor_data"}

    class Own(mikasa.RememberColor3VLAEnv):
        def compute_dense_reward(self, obs, action, info):
            return obs["sensor_param"]["hand_camera"]["extrinsic_cv"][:, 0, 3]

    mikasa.register_env("RememberColor3-Looks-VLA-v0", max_episode_steps=25)(Own)
    with made("RememberColor3-Looks-VLA-v0", num_envs=2, obs_mode="rgb") as env:
        chain = wrapped(env, mikasa.StateOnlyTensorToDictWrapper)
        assert chain.step(torch.zeros(2, 7))[1].abs().min() > 0


def test_the_environment_has_all_infos():
    with made(IDS[0], num_envs=2, obs_mode="rgb") as env:
        chain = mikasa.apply_mikasa_vla_wrappers(env)
        assert chain._source is env.unwrapped._observations
        chain.reset(seed=1)
        with pytest.raises(ValueError, match="shape"):
            chain.step(torch.zeros(2, 3))
        assert env.unwrapped._observations.wanted is Wanted.ALL
        whole = env.unwrapped.get_obs()
        assert list(whole) == ["agent", "extra", "sensor_param", "sensor_data"]
        assert list(env.step(torch.zeros(2, 7))[0]) == list(whole)


def test_fixed_matrices_are_the_callers_too():
    with made(IDS[0], num_envs=2, obs_mode="rgb") as env:
        first, _ = env.reset(seed=1)
        fixed = first["sensor_param"]["base_camera"]
        kept = {name: value.clone() for name, value in fixed.items()}
        for value in fixed.values():
            value.zero_()
        second = env.step(torch.ones(2, 7))[0]["sensor_param"]
        assert same(second["base_camera"], kept)
        assert not same(second["hand_camera"], first["sensor_param"]["hand_camera"])


def test_the_time_limit_heeds_restored_states():
    with made(IDS[0], num_envs=2, max_episode_steps=5) as env:
        env.reset(seed=1)
        for _ in range(4):
            env.step(torch.zeros(2, 7))
        late = env.unwrapped.get_state()
        env.reset(seed=1)
        env.unwrapped.set_state(late)
        assert env.step(torch.zeros(2, 7))[3].all()
        env.reset(options={"env_idx": torch.tensor([0])})
        assert env.step(torch.zeros(2, 7))[3].tolist() == [False, True]


def test_actions_are_frozen_anew_in_every_episode():
    with made(IDS[0], num_envs=2) as env:
        env = mikasa.CurriculumPhaseNoopActionWrapper(env)
        for options in ({}, {"env_idx": torch.tensor([0, 1])}):
            env.reset(seed=1, options=options)
            assert not env.action(torch.ones(2, 7)).any()
            for _ in range(15):
                env.step(torch.ones(2, 7))
            assert env.action(torch.ones(2, 7)).all()
