"""Gymnasium's specification of an environment."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import gymnasium

from engram._ids import NAMESPACE
from engram.envs.compat import AutoresetMode
from engram.errors import BadStateError


def spec_of(arguments: Mapping[str, Any], defaults: Mapping[str, Any]) -> Any:
    """The specification from which gymnasium.make_vec, or gymnasium.make, makes the same again."""
    registered = gymnasium.registry.get(NAMESPACE + arguments["id"])
    if registered is None:
        raise BadStateError(f"{arguments['id']} is missing from Gymnasium's registry")
    kwargs = {
        name: value
        for name, value in arguments.items()
        if name not in ("id", "max_episode_steps")
        and (name not in defaults or value is not defaults[name])
    }
    if isinstance(kwargs.get("autoreset_mode"), AutoresetMode):
        kwargs["autoreset_mode"] = kwargs["autoreset_mode"].name  # strings survive EnvSpec.to_json
    fields = {**_fields(registered), "kwargs": kwargs}
    if arguments.get("max_episode_steps") is not None:
        fields["max_episode_steps"] = arguments["max_episode_steps"]
    return type(registered)(**fields)


def _fields(spec: Any) -> dict[str, Any]:
    names = ("id", "entry_point", "max_episode_steps", "vector_entry_point")
    return {name: getattr(spec, name) for name in names}
