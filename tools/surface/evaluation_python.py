"""Code and texts that follow from the options of an evaluation, in Python."""

from options_python import typed
from table import (
    ENUMS,
    EVALUATION,
    LIST,
    allowed,
    default_in_words,
    ordered,
    sentence,
    wrapped,
)

BY_HAND = ("config", "constants", "task_options", "perturb")  # conversions
KINDS = {"seed": "seed_value", "text": "text", "path": "path", "latency": "latency"}


def keywords(function):
    """Options and keywords of a function, in the order that was published."""
    options = [o for o in EVALUATION if o["python"] and (o["type"] or "signature" in o)]
    own = [{"python": k["name"], "type": None, **k} for k in LIST["evaluation_keyword"]]
    chosen = [o for o in options + own if function in o.get("functions", ("evaluate", "probe"))]
    return ordered(chosen, LIST["order"][function], "python")


def signature(function):
    def lines(indent):
        result = []
        for option in keywords(function):
            given = option.get("signature")
            if isinstance(given, dict):
                option = {**option, "signature": given[function]}
            kind, default = typed(option)
            kind = "int" if option["type"] == "seed" else kind
            result.append(f"{indent}{option['python']}: {kind} = {default},")
        return result

    return lines


def help_lines(function):
    """What a docstring says of the options."""

    def lines(indent):
        result = []
        for option in keywords(function):
            if "help" in option:
                result += wrapped(f"``{option['python']}``: {option['help']}", "    ", "    ")
        return result

    return lines


def fields(indent):
    """Each keyword, the extension's name, and its conversion."""
    result = [indent + "EVALUATION: dict[str, tuple[str, str | dict[str, int]]] = {"]
    for option in EVALUATION:
        if not option["type"] or not option["python"] or option["python"] in BY_HAND:
            continue
        kind = KINDS.get(option["type"], option["type"])
        if kind in ENUMS:
            kind = "maybe_text" if ENUMS[kind].get("text") else kind.upper()
        shown = kind if kind.isupper() else f'"{kind}"'
        result.append(f'{indent}    "{option["python"]}": ("{option["name"]}", {shown}),')
    return [*result, indent + "}"]


def table(indent):
    """The table of docs/evaluation.md."""
    result = ["| C, Python | command | key of results | meaning |", "| --- | --- | --- | --- |"]
    for option in EVALUATION:
        names = dict.fromkeys([option["name"], option["python"] or option["name"]])
        shown = ", ".join(f"`{name}`" for name in names)
        flag, key = (f"`{option[k]}`" if k in option else "-" for k in ("flag", "key"))
        about = sentence(option["meaning"], allowed(option), default(option))
        result.append(f"| {shown} | {flag} | {key} | {about} |")
    return result


def default(option):
    words = default_in_words(option)
    return "" if words == "none" else f"default: {words}"
