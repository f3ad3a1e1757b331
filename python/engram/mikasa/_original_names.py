"""Modules of the original's packages that engram has, and where their names come from."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from dataclasses import dataclass, field

from engram.mikasa import _families
from engram.mikasa.dataset_naming import env_id_to_dataset_name

# The packages that the original's distribution brings, and the simulator that it is built on.
PACKAGES = ("mikasa_robo_suite", "baselines", "mani_skill")

_VLA = "mikasa_robo_suite.vla"
_OURS = "engram.mikasa"
# Names that `import *` of a family's module brings along with the classes.
_ALONGSIDE = ("BaseEnv", "Pose", "register_env", "torch")


@dataclass(frozen=True)
class Source:
    """Contents of a module.

    Attributes:
        module: Module of engram that has its names; "": there are none.
        names: Those of them that it has; empty: all.
        modules: Names that are other modules.
    """

    module: str = ""
    names: tuple[str, ...] = ()
    modules: Mapping[str, str] = field(default_factory=dict)

    def offered(self) -> tuple[str, ...]:
        """Names for ``import *``."""
        if self.names or not self.module:
            return (*self.names, *self.modules)
        return tuple(importlib.import_module(self.module).__all__)


def _families_of_classes() -> dict[str, Source]:
    """The modules of ``memory_envs``, one per family, from the classes that engram has."""
    names: dict[str, list[str]] = {}
    for name, cls in importlib.import_module(f"{_OURS}.classes").CLASSES.items():
        names.setdefault(cls._family, []).append(name)
    return {
        f"{_VLA}.memory_envs.{env_id_to_dataset_name(family)}_vla": Source(
            f"{_OURS}.memory_envs", (*names[family], *_ALONGSIDE)
        )
        for family in _families.INFO_KEYS
        if family in names
    }


SOURCES: dict[str, Source] = {
    "mikasa_robo_suite": Source(modules={"memory_envs": f"{_VLA}.memory_envs"}),
    _VLA: Source(),
    f"{_VLA}.benchmarking": Source(f"{_OURS}.benchmarking"),
    f"{_VLA}.memory_envs": Source(f"{_OURS}.memory_envs"),
    **_families_of_classes(),
    f"{_VLA}.utils": Source(f"{_OURS}.wrappers"),
    f"{_VLA}.utils.apply_wrappers": Source(f"{_OURS}.apply_wrappers"),
    f"{_VLA}.utils.dataset_naming": Source(f"{_OURS}.dataset_naming"),
    f"{_VLA}.utils.wrappers": Source(f"{_OURS}.wrappers"),
    "baselines": Source(),
    "baselines.ppo": Source(),
    "baselines.ppo.ppo_memtasks": Source(f"{_OURS}.ppo_memtasks"),
    "mani_skill": Source(),
    "mani_skill.envs": Source(),
    "mani_skill.envs.sapien_env": Source(f"{_OURS}.env", ("BaseEnv",)),
    "mani_skill.utils": Source(),
    "mani_skill.utils.common": Source(f"{_OURS}.common"),
    "mani_skill.utils.gym_utils": Source(f"{_OURS}.gym_utils"),
    "mani_skill.utils.registration": Source(f"{_OURS}.registration", ("register_env",)),
    "mani_skill.utils.structs": Source(f"{_OURS}.agent", ("Pose",)),
    "mani_skill.utils.structs.pose": Source(f"{_OURS}.agent", ("Pose",)),
    "mani_skill.utils.wrappers": Source(
        f"{_OURS}.record", ("FlattenActionSpaceWrapper", "RecordEpisode")
    ),
    "mani_skill.utils.wrappers.flatten": Source(f"{_OURS}.record", ("FlattenActionSpaceWrapper",)),
    "mani_skill.utils.wrappers.record": Source(f"{_OURS}.record", ("RecordEpisode",)),
    "mani_skill.vector": Source(),
    "mani_skill.vector.wrappers": Source(),
    "mani_skill.vector.wrappers.gymnasium": Source(f"{_OURS}.vector", ("ManiSkillVectorEnv",)),
}

# Why engram has no such modules, by the beginning of their names.
REASONS = {
    "mikasa_robo_suite.rl": "engram has only ids with VLA in their names",
    f"{_VLA}.dataset_collectors": "scripts run from their files, by python -m engram.mikasa FILE",
    f"{_VLA}.utils.motion_planning": "`engram collect` writes the files that planners collect",
    f"{_VLA}.utils.shapes": "scenes are engram's own",
    "mani_skill.examples": "`engram collect` writes the files that planners collect",
    "mani_skill.trajectory": "states of the original's simulator do not exist here",
    "mani_skill.utils.building": "scenes are engram's own",
    "mani_skill.agents": "robots are engram's own",
    "mani_skill.sensors": "cameras are engram's own",
}


def reason(module: str) -> str:
    """Why there is no such module; "" where nothing more can be said."""
    for beginning, why in REASONS.items():
        if module == beginning or module.startswith(f"{beginning}."):
            return why
    return ""
