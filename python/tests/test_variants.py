"""Constants that users change, ids of their own, ranges that resets narrow."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from contextlib import closing

import gymnasium
import numpy as np
import pytest
from conftest import TASK

import engram

SLOW = {
    "COLORS": 2,
    "CUE_PHASE_STEPS": (30, 50),
    "EMPTY_PHASE_STEPS": np.array([30, 50]),
    "max_episode_steps": np.int64(150),
}


def steps_of_episode(env) -> int:
    env.reset(seed=0)
    steps, over = 0, False
    while not over:
        *_, terminated, truncated, _ = env.step(np.zeros(7, np.float32))
        over = terminated or truncated
        steps += 1
    return steps


def test_constants_change_the_task():
    with closing(
        engram.make_vec("RememberColor9-VLA-v0", 4, constants=SLOW, autoreset_mode="DISABLED")
    ) as env:
        assert env.description["candidates"] == 2
        assert env.description["horizon"] == 150
        assert env.description["changed"]["CUE_PHASE_STEPS"] == [30, 50]
        env.reset()
        for _ in range(150):
            _, _, _, truncated, _ = env.step(env.act("oracle"))
        assert truncated.all()
        assert all(sub_env.output("success_once") for sub_env in env.envs)


@pytest.mark.parametrize(
    ("constants", "message"),
    [
        ({"COLOURS": 5}, "did you mean 'COLORS'"),
        ({"COLORS": 12}, "12 given, a whole number from 2 to 9"),
        ({"COLORS": None}, "null given"),
        ({"COLORS": {"a": 1}}, "{a: 1} given"),
        ({"COLORS": object()}, "numbers, texts and lists"),
        ({"CUE_PHASE_STEPS": (1, 30)}, "no time to act"),
        ({3: 4}, "name in constants"),
        ([3], "a dict from names to values"),
    ],
)
def test_bad_constants_are_refused(constants, message):
    with pytest.raises(engram.Error, match=message):
        engram.make_vec(TASK, 2, constants=constants)


def test_a_variant_works_by_its_id():
    id = "RememberColor2-Python-v0"
    for _ in range(2):  # the second time is none
        engram.register(id, base="RememberColor9-VLA-v0", constants=SLOW, instruction="Touch it.")
    assert id in [task["id"] for task in engram.list()]
    assert engram.describe(id)["changed"]["COLORS"] == 2
    env = gymnasium.make(f"engram/{id}")
    assert env.spec.max_episode_steps == 150
    assert env.unwrapped.language_instruction == "Touch it."
    env.reset(seed=0)
    assert steps_of_episode(env) == 150
    env.close()
    with closing(engram.make_vec(id, 2)) as batch:
        batch.reset()
        assert batch.envs[1].language_instruction == "Touch it."
    result = engram.evaluate(
        lambda seen: np.zeros((len(seen["episode"]), 7), np.float32), id, episodes=2, obs="state"
    )
    assert result["tasks"][0]["variant"]["constants"]["COLORS"] == 2
    with pytest.raises(engram.InvalidArgumentError, match="defined in another way"):
        engram.register(id, base="RememberColor9-VLA-v0", constants={"COLORS": 3})
    with pytest.raises(engram.InvalidArgumentError, match="base"):
        engram.register("Other-v0")
    with pytest.raises(engram.InvalidArgumentError, match="id"):
        engram.register(base=TASK)


def test_variants_come_out_of_a_file(tmp_path):
    file = tmp_path / "variants.json"
    definition = {"id": "FromFile-v0", "base": TASK, "constants": {"COLORS": 4}}
    file.write_text(json.dumps({"variants": [definition, {"id": "Bad", "base": TASK}]}))
    with pytest.raises(engram.InvalidArgumentError, match="Bad"):
        engram.load_variants(file)
    assert "FromFile-v0" not in [task["id"] for task in engram.list()]
    file.write_text(json.dumps({"variants": [definition]}))
    engram.load_variants(file)
    assert "engram/FromFile-v0" in gymnasium.registry

    script = "import gymnasium, engram; gymnasium.make('engram/FromFile-v0').reset()"
    environment = {**os.environ, "ENGRAM_VARIANTS": str(file)}
    subprocess.run([sys.executable, "-c", script], check=True, env=environment)


@pytest.mark.parametrize("steps", [7, 25, 40])
def test_max_episode_steps_is_the_length_of_episodes(steps):
    env = gymnasium.make(f"engram/{TASK}", max_episode_steps=steps)
    assert steps_of_episode(env) == steps
    env.close()
    single = engram.make(TASK, max_episode_steps=steps)
    assert steps_of_episode(single) == steps
    single.close()
    with closing(engram.make_vec(TASK, 2, max_episode_steps=steps)) as batch:
        assert batch.description["horizon"] == steps
        assert batch.spec.max_episode_steps == steps
        batch.reset()
        for i in range(1, steps + 1):
            truncated = batch.step(np.zeros((2, 7), np.float32))[3]
            assert truncated.tolist() == [i == steps] * 2
    made = gymnasium.make_vec(f"engram/{TASK}", num_envs=2, max_episode_steps=steps)
    assert made.unwrapped.description["horizon"] == steps
    made.close()


def test_the_limit_of_gymnasium_make_is_given_to_it():
    with pytest.raises(engram.InvalidArgumentError, match="give it to gymnasium"):
        gymnasium.make(f"engram/{TASK}", constants={"max_episode_steps": 60})


def empty_steps(env, options) -> np.ndarray:
    """Steps of the empty phase, in which the object is reported far above the table."""
    observation, _ = env.reset(seed=1, options=options)
    hidden = np.zeros(env.num_envs, int)
    for _ in range(99):
        hidden += (np.abs(observation) > 900).any(axis=1)
        observation, *_ = env.step(np.zeros((env.num_envs, 7), np.float32))
    return hidden


def test_resets_narrow_ranges():
    constants = {"EMPTY_PHASE_STEPS": (1, 60), "max_episode_steps": 100}
    with closing(engram.make_vec(TASK, 16, constants=constants)) as env:
        env.reset()
        narrow = {"EMPTY_PHASE_STEPS": (2, 3)}
        steps = empty_steps(env, {"constants": narrow})
        assert set(steps) == {2, 3}
        mask = np.arange(16) < 8
        env.reset(options={"constants": {}, "reset_mask": mask})
        steps = empty_steps(env, None)
        assert max(steps[:8]) > 10
        assert set(steps[8:]) <= {2, 3}
        with pytest.raises(engram.Error, match="from 1 to 60"):
            env.reset(options={"constants": {"EMPTY_PHASE_STEPS": (1, 61)}})
        with pytest.raises(engram.Error, match="did you mean 'EMPTY_PHASE_STEPS'"):
            env.reset(options={"constants": {"EMPTY_PHASE_STEP": 3}})
