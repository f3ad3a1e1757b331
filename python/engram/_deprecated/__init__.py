"""Former names of modules, as the last entry of engram's search path."""

from __future__ import annotations

import importlib
import sys
import warnings

MOVED = {
    "env": "envs.env",
    "lerobot": "integrations.lerobot",
    "making": "factory",
    "registration": "gym_registration",
    "registry": "tasks",
    "sb3": "integrations.sb3",
    "sub_env": "envs.sub_env",
    "vector_env": "envs.vector_env",
}


def redirect(name: str) -> None:
    """Puts the module that has taken over from engram.<name> in its place."""
    old, new = f"engram.{name}", f"engram.{MOVED[name]}"
    sys.modules[old] = importlib.import_module(new)
    # Frames of the import system do not count: level 3 is the importing module.
    warnings.warn(f"{old} is now {new}", DeprecationWarning, stacklevel=3)
