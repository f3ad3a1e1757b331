"""Code without type errors."""

from __future__ import annotations

import gymnasium
import numpy as np
from numpy.typing import NDArray

import engram
from engram import kit
from engram.typing import EnvOptions, RgbObservation, TaskDescription

TASK = "RememberColor9-VLA-v0"


def pictures(env: engram.VectorEnv[RgbObservation]) -> NDArray[np.uint8]:
    obs, _ = env.reset(seed=[1, 2, 3, 4], options={"pins": {"target": 2}})
    return obs["rgb"]


def run(num_envs: int) -> float:
    env = engram.make_vec(
        TASK,
        num_envs=num_envs,
        obs_mode="rgb",
        seed=None,
        autoreset_mode=engram.AutoresetMode.SAME_STEP,
        cameras=["hand_camera"],
        image_size=(64, 48),
        pins={"target": [2]},
        constants={"COLORS": 7},
        copy=False,
        privileged=True,
    )
    images = pictures(env)
    obs, reward, terminated, truncated, info = env.step(env.act("oracle"))
    if (terminated | truncated).any():
        print(info["final_info"], images.shape, obs["proprio"].mean(), len(env), env.instructions)
    env.close()
    return float(reward.sum())


def parts() -> NDArray[np.float32]:
    rows, _ = engram.make_vec(TASK, 2).reset()
    state, _ = engram.make_vec(TASK, 2, obs_mode="state_dict").reset()
    objects, _ = engram.make(TASK, obs_mode="objects_dict").reset()
    seen, _ = engram.make_vec(TASK, 2, obs_mode="rgb+depth+segmentation").reset()
    print((seen["depth"] * (seen["segmentation"] > 0)).mean(), seen["rgb"].shape)
    return np.concatenate([rows, state["agent"]["qpos"], objects["objects"]["seen"]])


def one(mode: EnvOptions) -> gymnasium.Env[NDArray[np.float32], NDArray[np.float32]]:
    env = engram.make(TASK, render_mode="rgb_array", render_camera="base_camera")
    obs, reward, terminated, truncated, info = env.step(env.act())
    print(obs.shape, reward + 1, terminated or truncated, info["success"], env.language_instruction)
    print(engram.make(TASK, **mode), engram.Env(TASK, obs_mode="rgb").task)
    return env


def descriptions() -> TaskDescription:
    described = engram.describe(TASK, obs_mode="objects", rules="original")
    print([output["name"] for output in described["outputs"] if output["privileged"]])
    print({task["id"]: task["horizon"] + 1 for task in engram.list()})
    try:
        engram.VectorEnv(TASK, 4, threads=2)
    except (engram.UnknownIdError, engram.BadStateError) as error:
        print(error)
    return described


class Touch(engram.Task):
    COLORS = kit.Integer(3, low=2, high=9, text="cubes")
    WAIT = kit.Steps(1, 5, text="steps")
    REACH = kit.Real(0.05, low=0.01, high=0.2, text="m")

    success_reward = 3.0

    def build(self) -> None:
        self.candidates = self.COLORS
        low, high = self.WAIT
        self.cubes = self.add_props(kit.Cube(f"c_{i}", color="red") for i in range(self.COLORS))
        self.draw_integer("target", 0, self.COLORS - 1, text="x")
        self.remember("seen", bool, width=(2, low + high))

    def advance(self) -> None:
        self.place(self.cubes[self.target], (0, 0), where=self.elapsed == 1)
        self.place(self.cubes, (0, 0, 0.1), where=self.begins("act"))

    def evaluate(self) -> None:
        self.success[:] = self.tcp_distance(self.pos_of(self.cubes[0])) < self.REACH
        self.seen |= True

    def reward(self) -> NDArray[np.float64]:
        return np.where(self.success, 3.0, 0.0)

    def oracle(self) -> None:
        self.touch(self.pos_of(self.cubes[self.target]))


def register() -> None:
    engram.register_task(Touch, "Typed-v0", 20, "Touch it.")
