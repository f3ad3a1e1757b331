"""The examples that bring engram into other people's loops run in those loops."""

from __future__ import annotations

import asyncio
import importlib.util
import pathlib

import numpy as np
import pytest
from conftest import TASK

import engram
from engram._compat import GYMNASIUM_1

EXAMPLES = pathlib.Path(__file__).resolve().parents[1] / "examples"


def load(name: str):
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.skipif(not GYMNASIUM_1, reason="LeRobot needs Gymnasium 1.x")
def test_lerobot_environment_has_the_contract_of_its_rollout():
    env = load("lerobot_env").make_env(n_envs=3, task=TASK)["engram"][0]
    obs, _ = env.reset(seed=[4, 5, 6])
    assert env.observation_space.contains(obs)
    assert env.call("_max_episode_steps")[0] == 25
    assert all(env.call("task_description"))
    assert env.envs[0].task == TASK
    for step in range(25):
        assert obs["pixels"]["wrist"].shape == (3, 128, 128, 3)
        obs, _, terminated, truncated, info = env.step(env.unwrapped.act("oracle"))
        assert ("final_info" in info) == (step == 24)
    assert (terminated | truncated).all()
    assert info["final_info"]["is_success"].tolist() == [True] * 3
    env.close()


@pytest.mark.skipif(not GYMNASIUM_1, reason="LeRobot needs Gymnasium 1.x")
def test_lerobots_own_functions_take_the_environment():
    pytest.importorskip("lerobot")
    utils = pytest.importorskip("lerobot.envs.utils", exc_type=ImportError)
    env = load("lerobot_env").make_env(n_envs=2, task=TASK)["engram"][0]
    obs, _ = env.reset(seed=[1, 2])
    utils.check_env_attributes_and_types(env)
    converted = utils.add_envs_task(env, utils.preprocess_observation(obs))
    assert converted["observation.images.top"].shape == (2, 3, 128, 128)
    assert converted["observation.state"].shape == (2, 7)
    assert converted["task"] == list(env.call("language_instruction"))
    env.close()


def test_vla_eval_runs_an_episode():
    pytest.importorskip("vla_eval")
    benchmark = load("vla_eval_benchmark").EngramBenchmark(tasks=[TASK])
    assert benchmark.get_metadata() == {"max_steps": 25}

    async def episode(number: int) -> dict:
        task = {**benchmark.get_tasks()[0], "episode_idx": number}
        await benchmark.start_episode(task)
        seen = await benchmark.get_observation()
        assert seen["images"]["hand_camera"].shape == (128, 128, 3)
        assert seen["state"].shape == (7,)
        assert seen["task_description"]
        while not await benchmark.is_done():
            await benchmark.apply_action({"actions": benchmark._env.act("oracle")})
        return await benchmark.get_result()

    assert asyncio.run(episode(3)) == {"success": True}
    own = engram.make(TASK)
    own.reset(seed=4242424242 + 3)
    benchmark._env.reset(seed=4242424242 + 3)
    np.testing.assert_array_equal(
        own.batch._views["proprio"], benchmark._env.batch._views["proprio"]
    )
    own.close()
    benchmark.cleanup()
