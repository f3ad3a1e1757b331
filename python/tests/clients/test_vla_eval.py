"""vla-evaluation-harness, as released: its own run of the example's benchmark, server included."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

pytest.importorskip("vla_eval")

import numpy as np
import vla_eval.api
from conftest import TASK
from vla_eval.model_servers.predict import PredictModelServer

import engram

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
EPISODES = 3


class Pusher(PredictModelServer):
    """A policy as a function of its observation: away from the gripper, and down."""

    def __init__(self):
        super().__init__()
        self.seen: list[dict] = []

    def predict(self, obs, ctx):
        self.seen.append(obs)
        return {"actions": act(np.asarray(obs["state"]))}


def act(proprio: np.ndarray) -> np.ndarray:
    action = np.zeros(7, np.float32)
    action[:3] = [*np.sign(proprio[:2]), -1]
    action[6] = 1
    return action


@pytest.fixture(autouse=True)
def examples_on_the_path(monkeypatch):
    monkeypatch.syspath_prepend(str(EXAMPLES))
    yield
    sys.modules.pop("vla_eval_benchmark", None)


def test_the_harness_runs_the_benchmark(tmp_path):
    server = Pusher()
    (result,) = vla_eval.api.evaluate(
        server,
        {
            "benchmarks": [
                {
                    "benchmark": "vla_eval_benchmark:EngramBenchmark",
                    "episodes_per_task": EPISODES,
                    "params": {"tasks": [TASK]},
                }
            ]
        },
        output_dir=tmp_path,
        docker=False,
    )
    (task,) = result["tasks"]
    assert (task["task"], task["num_episodes"], task["avg_steps"]) == (TASK, EPISODES, 25)
    assert "num_errors" not in task
    # One policy, in a loop of our own.
    env, step = engram.make(TASK, obs_mode="rgb"), 0
    for episode in range(EPISODES):
        obs, info = env.reset(seed=4242424242 + episode)
        for _ in range(25):
            seen = server.seen[step]
            np.testing.assert_array_equal(seen["state"], obs["proprio"])
            np.testing.assert_array_equal(seen["images"]["base_camera"], obs["rgb"][..., :3])
            np.testing.assert_array_equal(seen["images"]["hand_camera"], obs["rgb"][..., 3:])
            assert seen["task_description"] == env.language_instruction
            obs, *_, info = env.step(act(obs["proprio"]))
            step += 1
        assert task["episodes"][episode]["metrics"]["success"] == info["success_once"]
    assert step == len(server.seen)
    env.close()


def test_an_oracle_succeeds():
    from vla_eval_benchmark import EngramBenchmark

    benchmark = EngramBenchmark(tasks=[TASK])
    assert benchmark.get_metadata() == {"max_steps": 25}
    task = {**benchmark.get_tasks()[0], "episode_idx": 3}
    benchmark.reset(task)
    for _ in range(25):
        result = benchmark.step({"actions": benchmark._env.act("oracle")})
    assert result.done
    assert benchmark.get_step_result(result) == {"success": True}
    benchmark.cleanup()
