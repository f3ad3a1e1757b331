"""Registration of tasks of one's own."""

from __future__ import annotations

import gymnasium as gym
import numpy as np
import pytest

import engram
from engram import kit


def lamp(goal: int) -> type[engram.Task]:
    class Lamp(engram.Task):
        def build(self) -> None:
            self.cube = self.add_prop(kit.Cube("cube", color="red"))

        def reset(self) -> None:
            self.place(self.cube, (0, 0))

        def evaluate(self) -> None:
            self.success[:] = self.elapsed >= goal

        def reward(self) -> np.ndarray:
            return self.success * 1.0

    return Lamp


def row(id: str) -> dict:
    return next(task for task in engram.list() if task["id"] == id)


def steps_to_success(env: engram.VectorEnv) -> int:
    env.reset()
    for step in range(1, 20):
        info = env.step(np.zeros((env.num_envs, 7), np.float32))[4]
        if info["success"].all():
            return step
    return 0


def test_a_task_that_is_registered_again_takes_the_place_of_the_earlier_one() -> None:
    engram.register_task(lamp(3), "LampAgain-v0", 10, "Wait.")
    count = len(engram.list())
    early = engram.make_vec("LampAgain-v0", num_envs=2, autoreset_mode="DISABLED")
    engram.register_task(lamp(5), "LampAgain-v0", 12, "Wait longer.")
    assert len(engram.list()) == count
    assert row("LampAgain-v0")["horizon"] == 12
    assert row("LampAgain-v0")["instruction"] == "Wait longer."
    assert gym.spec("engram/LampAgain-v0").max_episode_steps == 12
    late = engram.make_vec("LampAgain-v0", num_envs=2, autoreset_mode="DISABLED")
    assert (steps_to_success(early), steps_to_success(late)) == (3, 5)


def test_arrays_that_a_caller_keeps_outlive_the_batch() -> None:
    kept = []

    class Keeper(lamp(3)):  # type: ignore[misc]
        def evaluate(self) -> None:
            kept.append(self.elapsed)
            super().evaluate()

    engram.register_task(Keeper, "Keeper-v0", 10, "Wait.")
    env = engram.make_vec("Keeper-v0", num_envs=4)
    env.reset()
    env.close()
    del env
    assert (kept[-1] == 0).all()


def test_a_batch_says_that_its_task_has_failed() -> None:
    broken = {"now": False}

    class Breaks(lamp(3)):  # type: ignore[misc]
        def advance(self) -> None:
            if broken["now"]:
                raise RuntimeError("the lamp is broken")

    engram.register_task(Breaks, "Breaks-v0", 10, "Wait.")
    env = engram.make_vec("Breaks-v0", num_envs=3)
    env.reset()
    actions = np.zeros((3, 7), np.float32)
    env.step(actions)
    broken["now"] = True
    with pytest.raises(RuntimeError, match=r"^the lamp is broken$"):
        env.step(actions)
    broken["now"] = False
    with pytest.raises(engram.BadStateError, match="failed in the middle of a step or reset"):
        env.step(actions)
    env.reset()
    env.step(actions)
