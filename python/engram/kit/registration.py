"""``engram.register_task``."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any

from engram import _core
from engram._args import values
from engram._ids import NAMESPACE
from engram.errors import InvalidArgumentError
from engram.gym_registration import register
from engram.kit.constants import constants_of
from engram.kit.sources import source_of
from engram.kit.task import Task

_NEEDED = ("evaluate", "reward")
# By id, in the order of registration: the definition as JSON, and what makes instances.
definitions: dict[str, tuple[str, Callable[[str, str], Task]]] = {}
# True while files are loaded whose tasks are registered with Gymnasium together, at their end.
gymnasium_waits = False


def register_task(
    cls: type[Task],
    id: str,
    horizon: int,
    instruction: str,
    *,
    family: str | None = None,
    oracle_floor: float = 0.95,
) -> None:
    """Registers a task of one's own, here and with Gymnasium as "engram/<id>".

    The id then works like those of built-in tasks. To register it again replaces the class;
    environments that were made before keep theirs.

    Args:
        cls: Derived from ``engram.Task``.
        id: A name that ends in -v and a number, such as "LampOrder-v0".
        horizon: Control steps of an episode.
        instruction: In English, what the robot has to do.
        family: Name of the tasks to which it belongs; None: the class's.
        oracle_floor: Success rate that its oracle reaches at least.

    Raises:
        InvalidArgumentError: The class or an argument is not as it should be.
    """
    if not (isinstance(cls, type) and issubclass(cls, Task) and cls is not Task):
        raise InvalidArgumentError(f"cls: {cls!r} given; a class derived from engram.Task needed")
    for name in _NEEDED:
        if getattr(cls, name) is getattr(Task, name):
            raise InvalidArgumentError(f"cls: {cls.__name__} has no method {name}()")
    horizon = values.integer("horizon", horizon, 1)
    definition = {
        "id": values.text("id", id),
        "family": cls.__name__ if family is None else values.text("family", family),
        "horizon": horizon,
        "instruction": values.text("instruction", instruction),
        "memory_type": values.text("memory_type", cls.memory_type),
        "oracle_floor": values.real("oracle_floor", oracle_floor),
        "constants": [one.definition(name) for name, one in constants_of(cls).items()],
        "source": source_of(cls),
    }
    cls(id, horizon, {}).describe()  # its mistakes come out here
    text, factory = json.dumps(definition), _factory(cls, horizon)
    _core.register_task(text, factory)
    if not gymnasium_waits:
        _replace_in_gymnasium(id)
    definitions.pop(id, None)
    definitions[id] = text, factory


def _factory(cls: type[Task], horizon: int) -> Callable[[str, str], Task]:
    def make(id: str, constants: str) -> Task:
        given: Mapping[str, Any] = json.loads(constants)
        return cls(id, int(given.get("max_episode_steps", horizon)), given)

    return make


def _replace_in_gymnasium(id: str) -> None:
    from gymnasium.envs import registration

    registration.registry.pop(NAMESPACE + id, None)
    register()
