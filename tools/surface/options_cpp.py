"""Code that follows from the list of options, in C, C++ and for the command."""

from cpp import call, default_in_c, default_in_cpp, quoted
from table import (
    CONVERTED,
    ENUMS,
    LIST,
    OPTIONS,
    TYPES,
    WIDTH,
    allowed,
    camel,
    comment,
    constant,
    default_in_words,
    enumerator,
    grouped,
    ordered,
    sentence,
)

# --- names for numbers ---


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
        result = [array, f"    {', '.join(quoted)},", "};"]
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
            result.append(f"static_assert(static_cast<int>({core}) == {c});")
    return result


# --- fields ---


def c_fields(options):
    """Fields of the struct of these options."""

    def lines(indent):
        result = []
        for option in options:
            about = sentence(option["meaning"], range_in_c(option), c_default_in_words(option))
            result += comment(indent, about, "/** ")
            declarations = option.get("c") or [f"{TYPES[option['type']][0]} {option['name']};"]
            result += [indent + line for line in declarations]
        return result

    return lines


def range_in_c(option):
    kind = option["type"]
    if kind in ENUMS and not ENUMS[kind].get("text"):
        return f"an engram_{kind}"
    return "-1 (the task's own rule), 0 or 1" if kind == "maybe" else allowed(option)


def c_default_in_words(option):
    if "unset" in option:
        return f"default NULL: {option['unset']}"
    if option.get("null") or option["type"] in ("path", "latency"):
        value = option["default"]
        return f"default NULL: {'none' if value is None else value}"
    if not option["type"]:
        return "" if option["default"] is None else f"default {default_in_words(option)}"
    return f"default {default_in_c(option)}"


def cpp_fields(layer, struct="", of=None):
    """Fields of a struct; layer: "cpp" or "core"; struct: which member of the options it is.

    of: only options of the batch ("batch") or of its task ("task").
    """

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
    """Checks of options of the batch or of its task; where pictures are made, theirs are."""

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
            sets = str(switch["sets"]).lower()
            arguments = [f'"{switch["name"]}"', f"options.{option['core']}", sets]
            help_ = quoted(switch["help"])
            result.append(call(f"{indent}add_switch(", ["command", *arguments, help_]))
    return result
