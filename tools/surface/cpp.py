"""Calls, texts and default values in C and C++."""

import json

from table import ENUMS, camel, constant, enumerator


def call(head, arguments, tail=");"):
    """A call or a signature in one line; head ends with "("."""
    return head + ", ".join(arguments) + tail


def quoted(text):
    return json.dumps(text, ensure_ascii=False)


def default_in_c(option):
    value = option["default"]
    if option["type"] == "maybe":
        return -1
    if "unset" in option or option.get("null"):
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
