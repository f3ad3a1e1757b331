"""Columns made by hand, and the calls that the engine makes, for tests of engram.Task alone."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from engram.kit.task import METHODS

ACTION_DIM = 7
_TYPES = {"bool": np.uint8, "int32": np.int32}


class ColumnsByHand:
    """One instance of a task and the arrays that a batch would hand it."""

    def __init__(self, cls: Any, num_envs: int = 4, horizon: int = 50, **constants: Any) -> None:
        self.task = cls("ByHand-v0", horizon, constants)
        self.description = json.loads(self.task.describe())
        self.num_envs = num_envs
        self.all = self._arrays(num_envs)
        self.some = self._arrays(num_envs)
        self.task.bind(self.all, self.some)

    def _arrays(self, rows: int) -> dict[str, np.ndarray]:
        described = self.description
        props = max(1, len(described["props"]))
        table: dict[str, tuple[Any, int]] = {
            "elapsed": (np.int32, 1), "seed": (np.uint64, 1), "episode": (np.uint64, 1),
            "policy_key": (np.uint64, 1), "qpos": (float, 9), "qvel": (float, 9),
            "tcp_pos": (float, 3), "tcp_quat": (float, 4), "action": (np.float32, ACTION_DIM),
            "previous_action": (np.float32, ACTION_DIM), "prop_pos": (float, 3 * props),
            "prop_quat": (float, 4 * props), "prop_qvel": (float, 6 * props),
            "prop_status": (np.uint8, props), "prop_rgba": (np.float32, 4 * props),
            "prop_emission": (np.float32, props), "covered": (np.uint64, 1),
            "finger_force": (float, 6 * props), "moved": (np.uint8, props),
            "success": (np.uint8, 1), "failed": (np.uint8, 1), "freeze_steps": (np.int32, 1),
            "cue_end": (np.int32, 1), "reward": (np.float32, 1), "actions": (np.float32, 7),
        }  # fmt: skip
        if described["oracle_dim"]:
            table["oracle_info"] = (np.int32, described["oracle_dim"])
        if described["answer"]:
            table["answered"] = table["first_answer_correct"] = (np.uint8, 1)
            table["first_answer"] = (np.int32, 1)
        width = sum(field["width"] for field in described["state_fields"])
        if width:
            table["state"] = (np.float32, width)
        for draw in described["draws"]:
            real = draw["kind"] in ("real", "places")
            width = 2 * draw["count"] if draw["kind"] == "places" else draw.get("width", 0)
            table["draw:" + draw["name"]] = (float if real else np.int32, width or draw["count"])
        for kind in ("memory", "infos"):
            for one in described[kind]:
                dtype = _TYPES.get(one["dtype"], one["dtype"])
                table[f"{kind.removesuffix('s')}:{one['name']}"] = (dtype, one["width"])
        return {name: np.zeros((rows, width), dtype) for name, (dtype, width) in table.items()}

    def call(self, method: str, envs: list[int] | None = None) -> None:
        """One method for all environments, or for some of them by way of the spare rows."""
        number = METHODS.index(method)
        if envs is None:
            self.task.call(number, self.num_envs, True)
            return
        for name, column in self.all.items():
            self.some[name][: len(envs)] = column[envs]
        self.task.call(number, len(envs), False)
        for name, column in self.all.items():
            column[envs] = self.some[name][: len(envs)]

    def reset(self, envs: list[int] | None = None, **draws: Any) -> None:
        rows = range(self.num_envs) if envs is None else envs
        for name, column in self.all.items():
            if name.startswith(("prop_", "memory:", "info:", "moved")) or name == "elapsed":
                column[rows] = 0
        for name, value in draws.items():
            self.all["draw:" + name][rows] = np.reshape(value, (-1, 1) if np.ndim(value) else -1)
        for method in ("reset", "advance", "evaluate", "observe"):
            self.call(method, envs)

    def step(self) -> None:
        if "before_physics" in self.description["methods"]:
            self.call("before_physics")
        self.all["elapsed"] += 1
        for method in ("advance", "evaluate", "observe", "reward"):
            self.call(method)
