"""Gymnasium's specification of a batch."""

from __future__ import annotations

from typing import Any

import gymnasium

from engram._compat import GYMNASIUM_1, AutoresetMode
from engram.errors import BadStateError
from engram.registry import NAMESPACE


def spec_of(arguments: dict[str, Any], defaults: dict[str, Any]) -> Any:
    """The specification from which gymnasium.make_vec makes the same batch."""
    registered = gymnasium.registry.get(NAMESPACE + arguments["id"])
    if registered is None:
        raise BadStateError(f"{arguments['id']} is missing from Gymnasium's registry")
    kwargs = {
        name: value
        for name, value in arguments.items()
        if name not in ("id", "max_episode_steps") and value is not defaults[name]
    }
    if isinstance(kwargs.get("autoreset_mode"), AutoresetMode):
        kwargs["autoreset_mode"] = kwargs["autoreset_mode"].name  # strings survive EnvSpec.to_json
    fields = {**_fields(registered), "kwargs": kwargs}
    if arguments["max_episode_steps"] is not None:
        fields["max_episode_steps"] = arguments["max_episode_steps"]
    spec = type(registered)(**fields)
    if GYMNASIUM_1:
        spec.kwargs["vectorization_mode"] = "vector_entry_point"
    return spec


def _fields(spec: Any) -> dict[str, Any]:
    names = ("id", "entry_point", "max_episode_steps", "vector_entry_point")
    return {name: getattr(spec, name) for name in names}
