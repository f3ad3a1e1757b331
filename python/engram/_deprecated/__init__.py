"""Former names of modules. engram's search path ends here, so that they can still be imported."""

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
    # Of the frames between, the import system's do not count: the next is the importing one.
    warnings.warn(f"{old} is now {new}", DeprecationWarning, stacklevel=3)
