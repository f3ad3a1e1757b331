from __future__ import annotations

import subprocess
import sys
import warnings

import gymnasium
import numpy as np
import pytest
from conftest import TASK, registered_ids
from gymnasium.utils.env_checker import check_env

import engram
from engram.envs.compat import GYMNASIUM_1


def make_vec(id: str, num_envs: int, **options):
    if GYMNASIUM_1:
        return gymnasium.make_vec(id, num_envs=num_envs, **options)
    return gymnasium.make_vec(
        id, num_envs=num_envs, vectorization_mode="custom", vector_kwargs=options
    )


def test_every_task_is_registered():
    ids = [task["id"] for task in engram.list()]
    # Behind them are variants that other tests have registered.
    assert ids[: len(registered_ids())] == registered_ids()
    assert {f"engram/{id}" for id in ids} <= set(gymnasium.registry)


def test_make_vec_makes_our_batch():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = make_vec(f"engram/{TASK}", 4, reward_mode="sparse", seed=5)
    assert isinstance(env.unwrapped, engram.VectorEnv)
    assert env.num_envs == 4
    assert env.spec.id == f"engram/{TASK}"
    own = engram.make_vec(TASK, 4, seed=5)
    np.testing.assert_array_equal(env.reset()[0], own.reset()[0])
    env.close()
    own.close()


def test_make_makes_one_environment():
    env = gymnasium.make(f"engram/{TASK}", obs_mode="rgb", render_mode="rgb_array", render_size=32)
    assert isinstance(env.unwrapped, engram.Env)
    assert env.spec.max_episode_steps == 25
    obs, _ = env.reset(seed=1)
    assert env.observation_space.contains(obs)
    assert isinstance(env.unwrapped.language_instruction, str)
    assert env.render().shape == (32, 32, 3)
    steps, truncated = 0, False
    while not truncated:
        _, reward, _, truncated, _ = env.step(env.action_space.sample())
        steps += 1
    assert steps == 25
    assert isinstance(reward, float)
    env.close()


@pytest.mark.parametrize("obs_mode", ["state", "state_dict", "rgb"])
@pytest.mark.filterwarnings("ignore")
def test_gymnasiums_checker_accepts_the_single_environment(obs_mode):
    env = gymnasium.make(f"engram/{TASK}", obs_mode=obs_mode)
    check_env(env.unwrapped, skip_render_check=True)
    env.close()


def test_async_vector_env_of_single_environments():
    if not GYMNASIUM_1:
        pytest.skip("Gymnasium 0.29 starts its processes differently")
    env = gymnasium.make_vec(
        f"engram/{TASK}",
        num_envs=2,
        vectorization_mode="async",
        vector_kwargs={"context": "spawn"},
    )
    obs, _ = env.reset(seed=3)
    own = engram.make_vec(TASK, 2)
    np.testing.assert_array_equal(obs, own.reset(seed=3)[0])
    own.close()
    env.close()


def test_unknown_entry_points_are_attribute_errors():
    with pytest.raises(AttributeError):
        engram.gym_registration.nothing  # noqa: B018


@pytest.mark.parametrize("first", ["gymnasium", "engram"])
def test_either_package_may_be_imported_first(first):
    code = (
        f"import {first}, gymnasium, engram\n"
        "assert 'engram/RememberColor3-VLA-v0' in gymnasium.registry\n"
        "env = gymnasium.make('engram/RememberColor3-VLA-v0')\n"
        "env.reset()\n"
    )
    result = subprocess.run(
        [sys.executable, "-W", "error::UserWarning:gymnasium.envs", "-c", code],
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    assert "Traceback" not in result.stderr
