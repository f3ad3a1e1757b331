"""Environments of one process: none has a mutable object that another one has."""

from __future__ import annotations

import copy
import types
from collections import deque
from typing import Any

import gymnasium
import numpy as np
import pytest
from conftest import TASK

import engram
from engram.envs.compat import AutoresetMode

CUPS = "ShellGameTouch-VLA-v0"
FIXED = (int, float, str, bytes, type(None), type, np.dtype, AutoresetMode)
CODE = (types.ModuleType, types.FunctionType, types.BuiltinFunctionType)


def mutable_parts(root: Any) -> dict[int, tuple[str, Any]]:
    """Everything that attributes, keys and elements lead to, by identity, with the way there."""
    found: dict[int, tuple[str, Any]] = {}
    queue = deque([(root, "env")])
    while queue:
        part, way = queue.popleft()
        if id(part) in found or isinstance(part, (*FIXED, *CODE)):
            continue
        found[id(part)] = (way, part)
        if isinstance(part, dict):
            queue.extend((value, f"{way}[{key!r}]") for key, value in part.items())
        elif isinstance(part, (list, tuple, set)):
            queue.extend((value, f"{way}[{i}]") for i, value in enumerate(part))
        elif isinstance(part, types.MethodType):
            queue.append((part.__self__, f"{way}.__self__"))
        queue.extend((value, f"{way}.{name}") for name, value in vars_of(part).items())
        if hasattr(part, "metadata"):  # of the class, where the instance has none
            queue.append((part.metadata, f"{way}.metadata"))
    return {key: one for key, one in found.items() if is_mutable(one[1])}


def vars_of(part: Any) -> dict[str, Any]:
    return getattr(part, "__dict__", {})


def is_mutable(part: Any) -> bool:
    return isinstance(part, (dict, list, set, np.ndarray)) or bool(vars_of(part))


MAKERS = {
    "make": lambda: engram.make(TASK, obs_mode="rgb", pins={"target": 1}),
    "make_vec": lambda: engram.make_vec(TASK, 2, obs_mode="objects_dict"),
    "several": lambda: engram.make_vec({TASK: 1, CUPS: {"num_envs": 1, "pins": {}}}),
    "gymnasium": lambda: gymnasium.make(f"engram/{TASK}"),
    "out": lambda: engram.make_vec(TASK, 2, out={"reward": np.zeros(2, np.float32)}),
}


@pytest.mark.parametrize("duplicate", [None, copy.copy, copy.deepcopy])
@pytest.mark.parametrize("maker", MAKERS)
def test_two_environments_share_nothing_mutable(maker: str, duplicate: Any) -> None:
    one = MAKERS[maker]()
    if duplicate is not None and isinstance(one, gymnasium.Wrapper):
        one = one.unwrapped
    other = MAKERS[maker]() if duplicate is None else duplicate(one)
    for env in (one, other):
        env.reset(seed=1)
        env.step(env.action_space.sample())
    parts, others = mutable_parts(one), mutable_parts(other)
    assert [parts[key][0] for key in parts.keys() & others.keys()] == []
