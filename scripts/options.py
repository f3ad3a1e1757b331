#!/usr/bin/env python3
"""Writes what follows from api/options.toml: blocks between "begin options" and "end options".

options.py          brings all blocks up to date
options.py --check  exits with 1, naming the files, if one is stale
"""

import re
import sys
import textwrap
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
WIDTH = 100
LIST = tomllib.loads((ROOT / "api/options.toml").read_text())
ENUMS = {enum["name"]: enum for enum in LIST["enum"]}

# Of each type: in C, in C++, in Python.
TYPES = {
    "bool": ("int32_t", "bool", "bool"),
    "maybe": ("int32_t", "std::optional<bool>", "bool | None"),
    "int": ("int32_t", "int", "int"),
    "seed": ("uint64_t", "std::uint64_t", "int | None"),
    "real": ("double", "double", "float"),
    "text": ("const char*", "std::string", "str"),
}


def camel(name):
    return "".join(part.capitalize() for part in re.split("[_+-]", name))


for enum in LIST["enum"]:
    plain = "const char*" if enum.get("text") else "int32_t"
    TYPES[enum["name"]] = (plain, camel(enum["name"]), camel(enum["name"]))


def completed(option):
    """The option with everything said that the list may leave out."""
    cpp = option.get("cpp", option["name"])
    python = option.get("python", option["name"])
    return {"cpp": cpp, "core": cpp, "type": None, "default": None, **option, "python": python}


def ordered(items, order, key="name"):
    """In the order that was published, new ones last."""
    return sorted(items, key=lambda x: order.index(x[key]) if x[key] in order else len(order))


OPTIONS = [completed(option) for option in LIST["option"]]
CONVERTED = [option for option in OPTIONS if option["type"]]  # by their types

# --- words ---


def grouped(number, separator=","):
    return f"{number:,}".replace(",", separator) if abs(number) >= 10_000 else str(number)


def any_of(names):
    return " or ".join(filter(None, [", ".join(names[:-1]), names[-1]]))


def allowed(option, number=grouped):
    """What is allowed, as in "0 (one per core) to 1024"; nothing where everything is."""
    if "values" in option:
        quoted = [f'"{v}"' if isinstance(v, str) else str(v) for v in option["values"]]
        return any_of(quoted)
    if "low" not in option:
        return ""
    text = number(option["low"]) + (f" ({option['zero']})" if "zero" in option else "")
    text += f" to {number(option['high'])}" if "high" in option else " or more"
    return text + (f" {option['unit']}" if "unit" in option else "")


def sentence(meaning, *details):
    """As in "Meaning. What is allowed; default."."""
    text = capital(meaning) + "."
    details = "; ".join(filter(None, details))
    return f"{text} {capital(details)}." if details else text


def capital(text):
    return text[:1].upper() + text[1:]


def default_in_c(option):
    value = option["default"]
    if option["type"] == "maybe":
        return -1
    if "unset" in option:
        return "nullptr"
    if option["type"] in ENUMS and not ENUMS[option["type"]].get("text"):
        return constant(ENUMS[option["type"]], value)
    if isinstance(value, str):
        return f'"{value}"'
    return int(value) if isinstance(value, bool) else value


def default_in_cpp(option):
    value = option["default"]
    if option["type"] in ENUMS and "unset" not in option:
        return f"{camel(option['type'])}::{enumerator(value)}"
    if isinstance(value, list):
        return "{" + ", ".join(f'"{item}"' for item in value) + "}"
    words = {None: "std::nullopt", True: "true", False: "false"}
    if value is None or isinstance(value, bool):
        return words[value]
    return f'"{value}"' if isinstance(value, str) else str(value)


def default_in_words(option):
    value = option["default"]
    if "unset" in option:
        return option["unset"]
    if value in (None, []):
        return "the task's rule" if option["type"] == "maybe" else "none"
    if isinstance(value, list):
        return ", ".join(value)
    return {True: "on", False: "off"}[value] if isinstance(value, bool) else str(value)


def comment(indent, text, mark="// "):
    """A comment of its own, before what it speaks of. Doxygen reads "/// " and "/** "."""
    if mark.startswith("//"):
        return wrapped(text, indent + mark, indent + mark)
    return wrapped(text + " */", indent + mark, indent + " * ")


def wrapped(text, first, further):
    return textwrap.wrap(
        text,
        WIDTH,
        initial_indent=first,
        subsequent_indent=further,
        break_long_words=False,
        break_on_hyphens=False,
    )


# --- names for numbers ---


def enumerator(name):
    return "k" + camel(name)


def constant(enum, name):
    prefix = re.sub("_MODE$", "", enum["name"].upper())
    return f"ENGRAM_{prefix}_{re.sub('[+-]', '_', name.upper())}"


def enum_in_c(name):
    def lines(indent):
        enum = ENUMS[name]
        values = enum["values"]
        result = comment(indent, enum["meaning"], "/** ") if "meaning" in enum else []
        result.append(f"typedef enum engram_{name} {{")
        for number, value in enumerate(values):
            if "meaning" in value:
                result += comment("  ", sentence(value["meaning"]), "/** ")
            comma = "," * (number + 1 < len(values))
            result.append(f"  {constant(enum, value['name'])} = {number}{comma}")
        return [*result, f"}} engram_{name};"]

    return lines


def enum_in_cpp(enum, public):
    mark = "/// " if public else "// "
    result = comment("", enum["meaning"], mark) if "meaning" in enum else []
    result.append(f"enum class {camel(enum['name'])} {{")
    lines = []
    for value in enum["values"]:
        number = f" = {constant(enum, value['name'])}" if public and not enum.get("text") else ""
        lines.append(f"  {enumerator(value['name'])}{number},")
    longest = max(map(len, lines))
    meanings = [value.get("meaning") for value in enum["values"]]
    tail = "  ///< " if public else "  // "
    beside = all(text and longest + len(tail) + len(text) <= WIDTH for text in meanings)
    for line, text in zip(lines, meanings):
        if beside:
            line = f"{line:{longest}}{tail}{text}"
        elif text:
            result += comment("  ", sentence(text), mark)
        result.append(line)
    return [*result, "};"]


def names_in_cpp(enum, function=True):
    kind = camel(enum["name"])
    quoted = [f'"{value["name"]}"' for value in enum["values"]]
    array = f"inline constexpr std::array k{kind}Names = {{"
    result = [f"{array}{', '.join(quoted)}}};"]
    if len(result[0]) > WIDTH:
        row = f"    {', '.join(quoted)},"
        rows = [row] if len(row) <= WIDTH else [f"    {name}," for name in quoted]
        result = [array, *rows, "};"]
    if function:
        result.append(f"constexpr const auto& names_of({kind}) {{ return k{kind}Names; }}")
    return result


def core_enum(name):
    return lambda indent: [*enum_in_cpp(ENUMS[name], False), *names_in_cpp(ENUMS[name])]


def spaced(parts):
    """All lines of the parts, with an empty one between two parts."""
    return [line for part in parts for line in ["", *part]][1:]


def core_enums(indent):
    numbers = [enum for enum in LIST["enum"] if not enum.get("text") and enum["name"] != "rules"]
    return spaced([*enum_in_cpp(enum, False), *names_in_cpp(enum)] for enum in numbers)


def public_enums(indent):
    return spaced(enum_in_cpp(enum, True) for enum in LIST["enum"])


def asserts(indent):
    result = []
    for enum in LIST["enum"]:
        for value in [] if enum.get("text") else enum["values"]:
            core = f"{camel(enum['name'])}::{enumerator(value['name'])}"
            c = constant(enum, value["name"])
            line = f"static_assert(static_cast<int>({core}) == {c});"
            if len(line) > WIDTH:
                line = line.replace(" == ", " ==\n              ")
            result += line.split("\n")
    return result


# --- fields ---


def c_fields(indent):
    result = []
    for option in ordered(OPTIONS, LIST["order"]["c"]):
        kind = option["type"]
        range_ = allowed(option)
        if kind in ENUMS and not ENUMS[kind].get("text"):
            range_ = f"an engram_{kind}"
        if kind == "maybe":
            range_ = "-1 (the task's own rule), 0 or 1"
        default = default_in_c(option) if kind else default_in_words(option)
        if "unset" in option:
            default = f"NULL: {option['unset']}"
        result += comment(indent, sentence(option["meaning"], range_, f"default {default}"), "/** ")
        declarations = option.get("c") or [f"{TYPES[kind][0]} {option['name']};"]
        result += [indent + line for line in declarations]
    return result


def cpp_fields(layer, struct="", of=None):
    """Fields of a struct; layer: "cpp" or "core"; struct: which member of the options it is.

    of: only options of the batch ("batch") or of its task ("task")."""

    def lines(indent):
        result = []
        for option in OPTIONS:
            where, _, field = option[layer].rpartition(".")
            if where != struct or of not in (None, option.get("of", "batch")):
                continue
            kind = TYPES[option["type"]][1] if option["type"] else option[layer + "_type"]
            kind = f"std::optional<{kind}>" if "unset" in option else kind
            mark = "/// " if layer == "cpp" else "// "
            result += comment(indent, sentence(option["meaning"], allowed(option)), mark)
            result.append(f"{indent}{kind} {field} = {default_in_cpp(option)};")
        return result

    return lines


def limits(indent):
    ints = [o for o in OPTIONS if o["type"] == "int" and "high" in o and "." not in o["core"]]
    return [
        f"{indent}inline constexpr int kMax{camel(o['name'])} = {grouped(o['high'], chr(39))};"
        for o in ints
    ]


def ranges(of):
    """Checks of options of the batch or of its task; those of pictures are made where pictures are."""

    def lines(indent):
        result = []
        for option in CONVERTED:
            text = allowed(option, str)
            if not text or "." in option["core"] or option.get("of", "batch") != of:
                continue
            if "values" in option:
                range_ = "{" + ", ".join(map(str, option["values"])) + "}"
            else:
                high = grouped(option["high"], "'") if "high" in option else "kNoLimit"
                range_ = f"{option['low']}, {high}"
            name = option["name"]
            core = f"options.{option['core']}"
            result.append(f'{indent}require("{name}", {core}, {range_}, "{text}");')
        return result

    return lines


def c_defaults(indent):
    options = ordered(CONVERTED, LIST["order"]["c"])
    return [f"{indent}options.{o['name']} = {default_in_c(o)};" for o in options]


def conversions(indent):
    return [
        f'{indent}convert("{o["name"]}", options.{o["name"]}, out.{o["core"]});' for o in CONVERTED
    ]


def copies(indent):
    return [f"{indent}c.{o['name']} = plain(options.{o['cpp']});" for o in CONVERTED]


def bindings(indent):
    options = ordered(CONVERTED, LIST["order"]["c"])
    return [f'{indent}field("{o["name"]}", &engram_options::{o["name"]});' for o in options]


def switches(indent):
    result = []
    for option in ordered([o for o in OPTIONS if "cli" in o], LIST["order"]["cli"]):
        cli = option["cli"]
        for switch in cli if isinstance(cli, list) else [cli]:
            result += switch_lines(indent, option, switch)
    return result


def switch_lines(indent, option, switch):
    sets = str(switch["sets"]).lower()
    call = f'{indent}add_switch(command, "{switch["name"]}", options.{option["core"]}, {sets},'
    help_ = f'"{switch["help"]}");'
    if len(call) + 1 + len(help_) <= WIDTH:
        return [f"{call} {help_}"]
    return [call, " " * len(f"{indent}add_switch(") + help_]


# --- Python, docs ---


def keywords():
    taken = [option for option in OPTIONS if option["python"]]
    own = [{"python": keyword["name"], "type": None, **keyword} for keyword in LIST["keyword"]]
    return ordered(taken + own, ["num_envs", *LIST["order"]["python"]], "python")


def typed(option):
    """Python's type of a keyword, and its default."""
    if "signature" in option:
        return tuple(option["signature"].rsplit(" = ", 1))
    kind = TYPES[option["type"]][2]
    if option["type"] == "text":
        kind = camel(option["name"])
    if "unset" in option:
        kind += " | None"
    return kind, default_in_python(option)


def signature(indent):
    named = [option for option in keywords() if not option.get("positional")]
    return [f"{indent}{o['python']}: {' = '.join(typed(o))}," for o in named]


def python_types(indent):
    names = {enum["name"]: [value["name"] for value in enum["values"]] for enum in LIST["enum"]}
    texts = {o["name"]: o["values"] for o in OPTIONS if o["type"] == "text"}
    result = []
    for name, values in {**names, **texts, **LIST["names"]}.items():
        if name == "auto_reset":
            continue  # autoreset_name has its names
        quoted = [f'"{value}"' for value in values]
        line = f"{camel(name)} = Literal[{', '.join(quoted)}]"
        if len(line) > WIDTH:
            result += [f"{camel(name)} = Literal[", *[f"    {q}," for q in quoted], "]"]
        else:
            result.append(line)
    for of_batch, head in ((False, "EnvOptions(TypedDict"), (True, "BatchOptions(EnvOptions")):
        about = "of batches too" if of_batch else "of environments, single or in batches"
        result += ["", "", f"class {head}, total=False):", f'    """Keywords {about}, but for obs_mode."""', ""]
        for option in keywords():
            taken = option["python"] not in ("num_envs", "obs_mode")
            if taken and option.get("batch", False) == of_batch:
                result.append(f"    {option['python']}: {typed(option)[0]}")
    return [*result, "", ""]


def default_in_python(option):
    value = option["default"]
    return f'"{value}"' if isinstance(value, str) else str(value)


def help_lines(indent):
    result = []
    for option in keywords():
        range_ = allowed(option)
        if option["type"] in ENUMS:
            range_ = any_of([f'"{value["name"]}"' for value in ENUMS[option["type"]]["values"]])
        text = option.get("help") or sentence(option["meaning"], range_)
        result += wrapped(f"{option['python']}: {text}", indent, indent + "    ")
    return result


def python_lists(indent):
    result = []
    for enum in LIST["enum"]:
        if enum.get("text"):
            continue
        pairs = [f'"{value["name"]}": {i}' for i, value in enumerate(enum["values"])]
        line = f"{enum['name'].upper()} = {{{', '.join(pairs)}}}"
        if len(line) > WIDTH:
            result += [line.split("{")[0] + "{", *[f"    {pair}," for pair in pairs], "}"]
        else:
            result.append(line)
    cameras = ", ".join(f'"{name}"' for name in LIST["names"]["camera"])
    result.append(f"CAMERAS = ({cameras})")
    side = next(option for option in OPTIONS if option["name"] == "image_width")
    result.append(f"IMAGE_SIDE = ({side['low']}, {side['high']})  # pixels")
    result += ["", "# Conversion of each keyword: by type, or by the numbers of its names."]
    result.append("KINDS: dict[str, str | dict[str, int]] = {")
    for option in CONVERTED:
        if option["python"] != option["name"] or "signature" in option:
            continue  # by hand
        kind = option["type"]
        if kind in ENUMS:
            kind = "text" if ENUMS[kind].get("text") else kind.upper()
            kind = f"maybe_{kind}" if "unset" in option else kind
        shown = kind if kind.isupper() else f'"{kind}"'
        result.append(f'    "{option["name"]}": {shown},')
    return [*result, "}"]


def values_in_words(enum):
    if enum.get("text"):
        return f"one of {len(enum['values'])}"
    names = [(f"`{value['name']}`", value.get("meaning")) for value in enum["values"]]
    return any_of([f"{name} ({text})" if text else name for name, text in names])


def table(indent):
    result = ["| option (C++ / C) | default | meaning |", "| --- | --- | --- |"]
    for option in OPTIONS:
        name = f"`{option['cpp']}`"
        if option["cpp"] != option["name"]:
            name += f" / `{option['name']}`"
        range_ = allowed(option)
        if option["type"] in ENUMS:
            range_ = values_in_words(ENUMS[option["type"]])
        text = "; ".join(filter(None, [option["meaning"], range_]))
        result.append(f"| {name} | {default_in_words(option)} | {text} |")
    return result


# --- files ---

BLOCKS = {
    "core/env/rules.h": {"enum": core_enum("rules")},
    "core/env/options.h": {
        "enums": core_enums,
        "limits": limits,
        "fields": cpp_fields("core", of="batch"),
        "task_fields": cpp_fields("core", of="task"),
    },
    "core/env/options.cc": {"ranges": ranges("batch"), "task_ranges": ranges("task")},
    "core/sim/control_mode.h": {"enum": core_enum("control_mode")},
    "core/image/image_options.h": {
        "shape": cpp_fields("core", "images"),
        "source": cpp_fields("core", "image_options"),
    },
    "api/engram/engram_options_c.h": {
        "obs_mode": enum_in_c("obs_mode"),
        "reward_mode": enum_in_c("reward_mode"),
        "auto_reset": enum_in_c("auto_reset"),
        "after_end": enum_in_c("after_end"),
        "rules": enum_in_c("rules"),
        "fields": c_fields,
    },
    "api/engram/engram_c.h": {"policy": enum_in_c("policy")},
    "api/engram/engram_options.h": {
        "enums": public_enums,
        "images": cpp_fields("cpp", "images"),
        "fields": cpp_fields("cpp"),
    },
    "api/engram/engram_impl.h": {
        "names": lambda indent: names_in_cpp(ENUMS["control_mode"], function=False),
        "copies": copies,
    },
    "api/c_options.cc": {"defaults": c_defaults, "conversions": conversions, "asserts": asserts},
    "apps/options.cc": {"switches": switches},
    "python/src/module.cc": {"bindings": bindings},
    "python/engram/_args/option_list.py": {"lists": python_lists},
    "python/engram/envs/vector_env.py": {"signature": signature},
    "python/engram/typing.py": {"types": python_types},
    "docs/embedding.md": {"table": table},
}

BLOCK = re.compile(r"^( *)(\S+) begin options: (\w+).*?\n(.*?)^ *\S+ end options", re.MULTILINE | re.DOTALL)
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
        text = HELP.sub(lambda _: "\n".join(help_lines(" " * 8)), text, count=1)
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
