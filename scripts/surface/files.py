"""Generated blocks of each file."""

import re

import options_cpp as cpp
import options_python as python
from table import ENUMS

# Arguments in a docstring, from the first one to where its errors begin.
ARGUMENTS = re.compile(r"(?<=\n)        num_envs: .*?(?=\n\n    Raises:)", re.DOTALL)

FILES = {
    "core/task/rules.h": {"enum": cpp.core_enum("rules")},
    "core/batch/options.h": {
        "enums": cpp.core_enums,
        "limits": cpp.limits,
        "fields": cpp.cpp_fields("core", of="batch"),
        "task_fields": cpp.cpp_fields("core", of="task"),
    },
    "core/batch/options.cc": {"ranges": cpp.ranges("batch"), "task_ranges": cpp.ranges("task")},
    "core/sim/control_mode.h": {"enum": cpp.core_enum("control_mode")},
    "core/image/image_options.h": {
        "shape": cpp.cpp_fields("core", "images"),
        "source": cpp.cpp_fields("core", "image_options"),
    },
    "api/engram/engram_options_c.h": {
        "obs_mode": cpp.enum_in_c("obs_mode"),
        "reward_mode": cpp.enum_in_c("reward_mode"),
        "auto_reset": cpp.enum_in_c("auto_reset"),
        "after_end": cpp.enum_in_c("after_end"),
        "rules": cpp.enum_in_c("rules"),
        "fields": cpp.c_fields,
    },
    "api/engram/engram_c.h": {"policy": cpp.enum_in_c("policy")},
    "api/engram/engram_options.h": {
        "enums": cpp.public_enums,
        "images": cpp.cpp_fields("cpp", "images"),
        "fields": cpp.cpp_fields("cpp"),
    },
    "api/engram/engram_impl.h": {
        "names": lambda indent: cpp.names_in_cpp(ENUMS["control_mode"], function=False),
        "copies": cpp.copies,
    },
    "api/c_options.cc": {
        "defaults": cpp.c_defaults,
        "conversions": cpp.conversions,
        "asserts": cpp.asserts,
    },
    "apps/options.cc": {"switches": cpp.switches},
    "python/src/module.cc": {"bindings": cpp.bindings},
    "python/engram/_args/option_list.py": {"lists": python.python_lists},
    "python/engram/envs/vector_env.py": {
        "signature": python.signature,
        ARGUMENTS: lambda indent: python.help_lines(" " * 8),
    },
    "python/engram/typing.py": {"types": python.python_types},
    "docs/embedding.md": {"table": python.table},
}
