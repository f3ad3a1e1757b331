#!/usr/bin/env python3
"""Writes what follows from api/options.toml: blocks between "begin options" and "end options".

options.py          brings all blocks up to date
options.py --check  exits with 1, naming the files, if one is stale
"""

import re
import sys

import options_cpp as cpp
import options_python as python
from option_list import ENUMS, ROOT

BLOCKS = {
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
    "python/engram/envs/vector_env.py": {"signature": python.signature},
    "python/engram/typing.py": {"types": python.python_types},
    "docs/embedding.md": {"table": python.table},
}

BLOCK = re.compile(
    r"^( *)(\S+) begin options: (\w+).*?\n(.*?)^ *\S+ end options", re.MULTILINE | re.DOTALL
)
# A docstring has no comments: its arguments end where its errors begin.
HELP = re.compile(r"(?<=\n)        num_envs: .*?(?=\n\n    Raises:)", re.DOTALL)


def rewritten(file, text):
    """The file's text with all blocks as the list has them."""
    blocks = dict(BLOCKS[file])

    def replace(match):
        indent, _, name, _ = match.groups()
        new = "".join(line.rstrip() + "\n" for line in blocks.pop(name)(indent))
        begin, end = match.start(4) - match.start(), match.end(4) - match.start()
        return match[0][:begin] + new + match[0][end:]

    text = BLOCK.sub(replace, text)
    if blocks:
        sys.exit(f"{file}: no block named {', '.join(blocks)}")
    if file.endswith("vector_env.py"):
        text = HELP.sub(lambda _: "\n".join(python.help_lines(" " * 8)), text, count=1)
    return text


def main():
    if sys.argv[1:] not in ([], ["--check"]):
        sys.exit(f"argument {sys.argv[1:]} given; allowed: --check")
    stale = []
    for file in BLOCKS:
        old = (ROOT / file).read_text()
        new = rewritten(file, old)
        if new != old:
            stale.append(file)
            if not sys.argv[1:]:
                (ROOT / file).write_text(new)
    if stale and sys.argv[1:]:
        sys.exit("stale, run scripts/options.py: " + ", ".join(stale))


if __name__ == "__main__":
    main()
