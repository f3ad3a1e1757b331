"""Modules of the original's packages that engram has, and where their names come from."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from engram.mikasa.dataset_naming import env_id_to_dataset_name

# The packages that the original's distribution brings, and the simulator that it is built on.
PACKAGES = ("mikasa_robo_suite", "baselines", "mani_skill")

_VLA = "mikasa_robo_suite.vla"
_RL = "mikasa_robo_suite.rl"
_OURS = "engram.mikasa"
# Names that `import *` of a family's module brings along with the classes.
_ALONGSIDE = ("BaseEnv", "Pose", "register_env", "torch")


@dataclass(frozen=True)
class Source:
    """Contents of a module.

    Attributes:
        module: Module of engram that has its names; "": there are none.
        names: Those of them that it has; empty: all.
    """

    module: str = ""
    names: tuple[str, ...] = ()

    def offered(self) -> tuple[str, ...]:
        """Names for ``import *``."""
        if self.names or not self.module:
            return self.names
        return tuple(importlib.import_module(self.module).__all__)


def _families_of_classes() -> dict[str, Source]:
    """The modules of ``memory_envs``, one per family, from the classes that engram has."""
    classes = importlib.import_module(f"{_OURS}.classes")
    return {
        **_modules(classes.CLASSES, f"{_OURS}.memory_envs", f"{_VLA}.memory_envs.{{}}_vla"),
        **_modules(classes.RL_CLASSES, f"{_OURS}.rl.memory_envs", f"{_RL}.memory_envs.{{}}"),
    }


def _modules(classes: Mapping[str, Any], module: str, form: str) -> dict[str, Source]:
    names: dict[str, list[str]] = {}
    for name, cls in classes.items():
        names.setdefault(cls._family, []).append(name)
    return {
        form.format(env_id_to_dataset_name(family)): Source(module, (*own, *_ALONGSIDE))
        for family, own in names.items()
    }


SOURCES: dict[str, Source] = {
    "mikasa_robo_suite": Source(),
    # Names of the first release, by which programs of the RL half still import.
    "mikasa_robo_suite.memory_envs": Source(f"{_OURS}.all_envs"),
    "mikasa_robo_suite.utils": Source(f"{_OURS}.rl.wrappers"),
    "mikasa_robo_suite.utils.wrappers": Source(f"{_OURS}.rl.wrappers"),
    _RL: Source(),
    f"{_RL}.memory_envs": Source(f"{_OURS}.rl.memory_envs"),
    f"{_RL}.utils": Source(f"{_OURS}.rl.wrappers"),
    f"{_RL}.utils.wrappers": Source(f"{_OURS}.rl.wrappers"),
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
    f"{_VLA}.dataset_collectors": "scripts run from their files, by python -m engram.mikasa FILE",
    f"{_RL}.dataset_collectors": "scripts run from their files, by python -m engram.mikasa FILE",
    f"{_RL}.utils.shapes": "scenes are engram's own",
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
