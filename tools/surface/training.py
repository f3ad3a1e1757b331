"""Options and numbers of the preset for training, in C, C++ and Python."""

from cpp import default_in_c, default_in_cpp
from options_cpp import c_fields
from options_python import typed
from table import LIST, TYPES, camel, comment, completed, sentence, wrapped

OPTIONS = [completed(option) for option in LIST["training_option"]]
NUMBERS = {number["name"]: number for number in LIST["training"]["numbers"]}
TERMS = LIST["training"]["terms"]
STILL, THERE = LIST["training"]["still"], LIST["training"]["there"]

c_options = c_fields(OPTIONS)


def cpp_options(public):
    def lines(indent):
        result = []
        for option in OPTIONS:
            result += comment(indent, sentence(option["meaning"]), "/// " if public else "// ")
            kind = TYPES[option["type"]][1]
            result.append(f"{indent}{kind} {option['name']} = {default_in_cpp(option)};")
        return result

    return lines


def defaults(indent):
    return [f"{indent}options->{o['name']} = {default_in_c(o)};" for o in OPTIONS]


def conversions(indent):
    return [
        f'{indent}convert("{o["name"]}", options.{o["name"]}, out.{o["name"]});' for o in OPTIONS
    ]


def copies(indent):
    return [f"{indent}c.{o['name']} = plain(options.{o['name']});" for o in OPTIONS]


def signature(indent):
    return [f"{indent}{o['name']}: {' = '.join(typed(o))}," for o in OPTIONS]


def help_lines(indent):
    result = []
    for option in OPTIONS:
        result += wrapped(f"{option['name']}: {option['help']}", " " * 8, " " * 12)
    return result


def values_of(number, pi):
    values = number["value"] if isinstance(number["value"], list) else [number["value"]]
    return ", ".join(str(value).replace("pi", pi) for value in values)


def number_in_cpp(number):
    value = values_of(number, "std::numbers::pi")
    name = "k" + camel(number["name"])
    if isinstance(number["value"], list):
        kind = f"std::array<double, {len(number['value'])}>"
        return f"inline constexpr {kind} {name} = {{{value}}};"
    return f"inline constexpr double {name} = {value};"


def cpp_numbers(*names):
    """These numbers, or all of them."""

    def lines(indent):
        result = []
        for number in [NUMBERS[name] for name in names or NUMBERS]:
            result += [*comment("", sentence(number["meaning"])), number_in_cpp(number)]
        return result

    return lines


def cpp_terms(indent):
    rows = [
        f'{{"{t["name"]}", {t["weight"]}, "{t.get("until", "")}", "{t.get("since", "")}"}},'
        for t in TERMS
    ]
    there = ", ".join(f'R"({name})"' if '"' in name else f'"{name}"' for name in THERE)
    return [
        f"inline constexpr std::array<TermRule, {len(rows)}> kTerms = {{{{",
        *rows,
        "}};",
        f'inline constexpr const char* kStill = "{STILL}";',
        f"inline constexpr std::array<const char*, {len(THERE)}> kThere = {{{there}}};",
    ]


def python_numbers(indent):
    result = []
    for number in NUMBERS.values():
        value = values_of(number, "math.pi")
        value = f"({value})" if isinstance(number["value"], list) else value
        result += wrapped(sentence(number["meaning"]), "# ", "# ")
        result.append(f"{number['name'].upper()} = {value}")
    return result


def python_terms(indent):
    result = ["TERMS = {", *[f'    "{t["name"]}": {t["weight"]},' for t in TERMS], "}"]
    for stage in ("until", "since"):
        pairs = [f'    "{t["name"]}": "{t[stage]}",' for t in TERMS if stage in t]
        result += [f"{stage.upper()} = {{", *pairs, "}"]
    there = ", ".join(f"'{name}'" if '"' in name else f'"{name}"' for name in THERE)
    return [*result, f'STILL = "{STILL}"', f"THERE = ({there})"]
