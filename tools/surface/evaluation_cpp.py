"""Code that follows from the options of an evaluation, in C, C++ and for the command."""

from cpp import call, default_in_c, default_in_cpp, quoted
from table import (
    ENUMS,
    EVALUATION,
    LIST,
    TYPES,
    allowed,
    camel,
    comment,
    grouped,
    ordered,
    sentence,
)

FIRST_KEYS = LIST["order"]["results"]
ENGINE = {"run": "settings", "environment": "environment"}  # variables that hold them
OF_C = [option for option in EVALUATION if option.get("c") != []]
OF_RUN = [option for option in EVALUATION if option.get("of") == "run"]
OF_ENVIRONMENT = [option for option in EVALUATION if option.get("of") == "environment"]
WRITTEN = [o for o in EVALUATION if "key" in o and o.get("document") != "hand"]


def camel_limit(option):
    return "kMax" + camel(option["name"])


def document_value(option, value):
    """An option's value in documents: names, not numbers that stand for them."""
    return f"name_of({value})" if option["type"] in ENUMS else value


def init(indent):
    """Defaults that are not 0."""
    zeros = (0, "nullptr", "ENGRAM_RULES_REFERENCE", "ENGRAM_PHYSICS_ENGRAM")
    return [
        f"{indent}options->{o['name']} = {default_in_c(o)};"
        for o in EVALUATION
        if o["type"] not in (None, "latency", "path")
        and default_in_c(o) not in zeros
        and o.get("c") != []
    ]


def constants(indent):
    """Named defaults and limits."""
    named = [
        f"{indent}inline constexpr {TYPES[o['type']][1]} {o['constant']} = {o['default']};"
        for o in EVALUATION
        if "constant" in o
    ]
    limits = [
        f"{indent}inline constexpr int {camel_limit(o)} = {grouped(o['high'], chr(39))};"
        for o in OF_RUN
        if "high" in o
    ]
    return named + limits


def run_fields(indent):
    result = []
    for option in OF_RUN:
        default = option.get("constant") or default_in_cpp(option)
        result += comment(indent, sentence(option["meaning"], allowed(option)))
        result.append(f"{indent}{TYPES[option['type']][1]} {option['core']} = {default};")
    return result


def conversions(indent):
    """From C to RunOptions and BatchOptions."""
    result = []
    for option in EVALUATION:
        if option.get("of") not in ENGINE or not option["type"] or option.get("c") == []:
            continue
        target = f"{ENGINE[option['of']]}.{option['core']}"
        arguments = [f'"{option["name"]}"', f"options.{option['name']}"]
        if "low" in option:
            high = f"engram::{camel_limit(option)}" if "high" in option else "kNoLimit"
            arguments += [str(option["low"]), high]
        result.append(call(f"{indent}convert(", [*arguments, target]))
    return result


def reads(indent):
    """From a document; an option whose key is missing keeps its default."""
    result = []
    for option in WRITTEN:
        limits = []
        if option["type"] in ("int", "latency"):
            limits = [str(option.get("low", 0)), camel_limit(option)]
        target = f"settings.{option['core']}"
        arguments = ["document", f'"{option["key"]}"', *limits, target]
        result.append(call(f"{indent}read(", arguments))
    return result


def document(indent):
    """Rows of the settings' document, but for those whose place is before the variants."""
    rows = [o for o in WRITTEN if o["name"] not in ("tell_episodes", "joint_proprio")]
    return [f'{indent}{{"{o["key"]}", {document_value(o, o["core"])}}},' for o in rows]


def keys(indent):
    names = [f'"{option["key"]}"' for option in WRITTEN]
    return [indent + ", ".join(names) + ","]


def own_keys(first):
    """Keys of a task's result, where the setting is not the default."""

    def lines(indent):
        result = []
        chosen = [o for o in WRITTEN if (o["name"] in FIRST_KEYS) == first]
        for option in ordered(chosen, FIRST_KEYS):
            field = f"settings.{option['core']}"
            when = option.get("when", f"{field} != usual.{option['core']}")
            value = document_value(option, field)
            result.append(call(f"{indent}add(", [f'"{option["key"]}"', when, value]))
        return result

    return lines


def report_rows(indent):
    shown = [option for option in OF_RUN if "report" in option]
    return [f'{indent}{{"{o["report"]}", std::to_string(settings.{o["core"]})}},' for o in shown]


def copies(target, source):
    """Settings of environments, from one struct to another."""
    return lambda indent: [
        f"{indent}{target}{o['core']} = {source}{o['core']};" for o in OF_ENVIRONMENT
    ]


def environment_fields(indent):
    """Fields of the settings that are those of a batch."""
    kinds = {"constants": "ConstantTable", "perturbations": "std::vector<PerturbationLevel>"}
    result = []
    for option in OF_ENVIRONMENT:
        kind = TYPES[option["type"]][1] if option["type"] else kinds[option["name"]]
        default = f" = {default_in_cpp(option)}" if option["type"] else ""
        result += comment(indent, sentence(option["meaning"]))
        result.append(f"{indent}{kind} {option['core']}{default};")
    return result


def keys_of_flags(indent):
    return [
        f'{indent}{{"{o["flag"]}", "{o["key"]}"}},'
        for o in EVALUATION
        if {"flag", "key"} <= o.keys()
    ]


def flags(indent):
    """Flags of the command, for the commands that have them."""
    result = []
    for option in ordered([o for o in OF_RUN if "cli" in o], LIST["order"]["flags"]):
        names = ", ".join(f'"{name}"' for name in option["commands"])
        limits = [str(option["low"]), camel_limit(option)] if option["type"] == "int" else []
        arguments = [f'"{option["flag"]}"', *limits, f"run.{option['core']}", quoted(option["cli"])]
        head = "command.add_flag(" if option["type"] == "bool" else "add(command, "
        result.append(f"{indent}if (in({{{names}}})) {{")
        result.append(call(f"{indent}  {head}", arguments))
        result.append(indent + "}")
    return result


def bindings(indent):
    typed = [o["name"] for o in OF_C if o["type"]]
    return [
        f'{indent}field("{name}", &engram_evaluation_options::{name});'
        for name in [*typed, "constants"]
    ]
