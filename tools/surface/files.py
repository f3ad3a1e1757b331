"""Generated blocks of each file."""

import re

import evaluation_cpp as evaluation
import evaluation_python
import options_cpp as cpp
import options_python as python
import queries_cpp as queries
import queries_python
import training
from table import ENUMS, LIST, OPTIONS, ordered

# Arguments in a docstring, from the first one to where its errors begin.
ARGUMENTS = re.compile(r"(?<=\n)        num_envs: .*?(?=\n\n    Raises:)", re.DOTALL)

# Arguments in the docstring of engram.wrappers.train.
TRAINING_ARGUMENTS = re.compile(r"(?<=\n)        gamma: .*?(?=\n        terms: )", re.DOTALL)

# Options in the docstring of engram.evaluate.
OPTIONS_TEXT = re.compile(
    r"(?<=\n)    ``rules``: .*?(?=\n\n    ``choices``: in place of)", re.DOTALL
)

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
        "physics": cpp.enum_in_c("physics"),
        "fields": cpp.c_fields(ordered(OPTIONS, LIST["order"]["c"])),
    },
    "api/engram/engram_c.h": {
        "policy": cpp.enum_in_c("policy"),
        "text_queries": queries.c_declarations("text"),
        "array_queries": queries.c_declarations("arrays"),
    },
    "api/engram/engram.h": {
        "text_queries": queries.cpp_declarations("text"),
        "array_queries": queries.cpp_declarations("arrays"),
    },
    "api/queries_c.cc": {"includes": queries.includes, "definitions": queries.c_definitions},
    "api/engram/engram_options.h": {
        "enums": cpp.public_enums,
        "images": cpp.cpp_fields("cpp", "images"),
        "fields": cpp.cpp_fields("cpp"),
    },
    "api/engram/engram_impl.h": {
        "names": lambda indent: cpp.names_in_cpp(ENUMS["control_mode"], function=False),
        "copies": cpp.copies,
        "queries": queries.cpp_definitions,
    },
    "api/c_options.cc": {
        "defaults": cpp.c_defaults,
        "conversions": cpp.conversions,
        "asserts": cpp.asserts,
    },
    "apps/options.cc": {"switches": cpp.switches},
    "python/src/module.cc": {
        "bindings": cpp.bindings,
        "array_queries": queries.extension,
        "queries": queries.bindings,
    },
    "python/engram/envs/queries.py": {"queries": queries_python.mixin},
    "python/engram/envs/env.py": {"queries": queries_python.single},
    "docs/evaluation.md": {
        "queries": queries.page,
        "options": evaluation_python.table,
    },
    "docs/reference/c.rst": {"queries": queries.reference},
    "python/engram/_args/option_list.py": {
        "lists": python.python_lists,
        "evaluation": evaluation_python.fields,
    },
    "python/engram/evaluation.py": {
        "evaluate": evaluation_python.signature("evaluate"),
        "probe": evaluation_python.signature("probe"),
        OPTIONS_TEXT: evaluation_python.help_lines("evaluate"),
    },
    "python/engram/envs/vector_env.py": {
        "signature": python.signature,
        ARGUMENTS: lambda indent: python.help_lines(" " * 8),
    },
    "python/engram/typing.py": {"types": python.python_types},
    "docs/embedding.md": {"table": python.table},
    "api/engram/engram_evaluation_c.h": {"fields": cpp.c_fields(evaluation.OF_C)},
    "api/evaluate_c.cc": {"conversions": evaluation.conversions, "init": evaluation.init},
    "protocol/eval/run/run_options.h": {
        "constants": evaluation.constants,
        "fields": evaluation.run_fields,
    },
    "protocol/eval/run/settings.h": {"environment": evaluation.environment_fields},
    "protocol/eval/run/settings.cc": {
        "reads": evaluation.reads,
        "environment": evaluation.copies("", "environment."),
        "document": evaluation.document,
        "environment_back": evaluation.copies("environment.", "settings."),
    },
    "protocol/eval/results/result_files.cc": {
        "keys": evaluation.keys,
        "first_keys": evaluation.own_keys(first=True),
        "further_keys": evaluation.own_keys(first=False),
    },
    "protocol/eval/results/evaluation_report.cc": {"rows": evaluation.report_rows},
    "apps/eval_options.cc": {"keys_of_flags": evaluation.keys_of_flags},
    "apps/run_flags.cc": {"flags": evaluation.flags},
    "python/src/evaluate.cc": {"bindings": evaluation.bindings},
    "protocol/training/numbers.h": {
        "numbers": training.cpp_numbers(),
        "terms": training.cpp_terms,
        "options": training.cpp_options(public=False),
    },
    "core/batch/batch_step.cc": {"pose": training.cpp_numbers("rest")},
    "api/engram/engram_training_c.h": {"fields": training.c_options},
    "api/engram/engram_training.h": {
        "fields": training.cpp_options(public=True),
        "copies": training.copies,
    },
    "api/training_c.cc": {
        "conversions": training.conversions,
        "defaults": training.defaults,
    },
    "python/engram/wrappers/numbers.py": {
        "numbers": training.python_numbers,
        "terms": training.python_terms,
    },
    "python/engram/wrappers/preset.py": {
        "options": training.signature,
        TRAINING_ARGUMENTS: training.help_lines,
    },
}
