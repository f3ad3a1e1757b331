"""Weights for AgentStateOnly that touch the right cube: a checkpoint without any learning."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium as gym
import torch

import engram
import engram.mikasa as mikasa

SMALL, LARGE = 1e-3, 20.0  # tanh(SMALL * x) is linear, tanh(LARGE) is 1
GAIN = 8.0  # of the tool's position, per m
ABOVE = 0.03  # of the cube's centre that the tool goes to, m
CUBES = 3
AXES = 3


def write_checkpoint(folder: Path) -> None:
    """The policy where the original's collector looks for one of RememberColor3."""
    id = "RememberColor3-VLA-v0"
    path = folder / "oracle_checkpoints" / id / "handmade" / "final_success_ckpt.pt"
    path.parent.mkdir(parents=True)
    torch.save(_agent(id).state_dict(), path)


def _agent(id: str) -> Any:
    env = gym.make(id, obs_mode="state", control_mode="pd_ee_delta_pose", threads=1)
    env = mikasa.FlattenRGBDObservationWrapper(
        mikasa.StateOnlyTensorToDictWrapper(env), rgb=False, depth=False
    )
    agent = mikasa.AgentStateOnly(mikasa.ManiSkillVectorEnv(env, 1))
    env.close()
    begins = {field["name"]: field["offset"] for field in engram.describe(id)["state_fields"]}
    layers = [agent.actor_mean[i] for i in (0, 2, 4, 6)]
    with torch.no_grad():
        for layer in layers:
            layer.weight.zero_()
            layer.bias.zero_()
        _fill(*layers, begins)
    return agent


def _fill(first: Any, second: Any, third: Any, last: Any, begins: dict[str, int]) -> None:
    # Units 0 and 1: whether the answer is beyond cube 0, and beyond cube 1; -1 or 1.
    for unit, border in enumerate((0.5, 1.5)):
        first.weight[unit, begins["oracle_info"]] = LARGE
        first.bias[unit] = -LARGE * border
    for cube in range(CUBES):
        for axis in range(AXES):
            way = 2 + cube * AXES + axis  # from the tool to the cube, small
            first.weight[way, begins[f"goal_{cube}_pose"] + axis] = SMALL
            first.weight[way, begins["tcp_pose"] + axis] = -SMALL
            first.bias[way] = SMALL * ABOVE if axis == 2 else 0
            # Pairs of units that differ by the way where the cube is the answer, and else by 0.
            second.weight[way, way] = 1
            for unit in (way, way + CUBES * AXES):
                signs = ((1, 0), (-1, 1), (0, -1))[cube]
                second.weight[unit, :2] = LARGE * torch.tensor(signs, dtype=torch.float32)
                second.bias[unit] = LARGE * (1, 2, 1)[cube]
            third.weight[axis, way] = 1
            third.weight[axis, way + CUBES * AXES] = -1
    for axis in range(AXES):
        last.weight[axis, axis] = GAIN / SMALL
    last.bias[6] = -1  # a closed gripper
