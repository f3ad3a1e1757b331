"""Gymnasium's specification of an environment."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np
from gymnasium.envs.registration import EnvSpec

from engram._ids import NAMESPACE
from engram.envs.compat import AutoresetMode
from engram.errors import BadStateError

# Arguments that are no part of the specification's keywords: arrays belong to one batch alone.
_APART = ("id", "max_episode_steps", "out")
# Several tasks; their ids are among the keywords.
_GROUP = EnvSpec(NAMESPACE + "Group", None, vector_entry_point="engram.factory:make_vec")


def spec_of(arguments: Mapping[str, Any], defaults: Mapping[str, Any]) -> Any:
    """The specification from which gymnasium.make_vec, or gymnasium.make, makes the same again."""
    task = arguments["id"]
    registered = gymnasium.registry.get(NAMESPACE + task) if isinstance(task, str) else _GROUP
    if registered is None:
        raise BadStateError(f"{task} is missing from Gymnasium's registry")
    kwargs = {
        name: _plain(value)
        for name, value in arguments.items()
        if name not in _APART and (name not in defaults or value is not defaults[name])
    }
    if isinstance(kwargs.get("autoreset_mode"), AutoresetMode):
        kwargs["autoreset_mode"] = kwargs["autoreset_mode"].name  # strings survive EnvSpec.to_json
    if registered is _GROUP:
        kwargs["id"] = _plain(task)
    fields = {**_fields(registered), "kwargs": kwargs}
    if arguments.get("max_episode_steps") is not None:
        fields["max_episode_steps"] = arguments["max_episode_steps"]
    return type(registered)(**fields)


def _plain(value: Any) -> Any:
    """The value without NumPy's types, which EnvSpec.to_json refuses."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, Mapping):
        return {_plain(key): _plain(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return type(value)(_plain(one) for one in value)
    return value


def _fields(spec: Any) -> dict[str, Any]:
    names = ("id", "entry_point", "max_episode_steps", "vector_entry_point")
    return {name: getattr(spec, name) for name in names}
