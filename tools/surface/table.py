"""The tables of api/surface.toml, and the words and names that its texts are made of."""

import re
import textwrap
from pathlib import Path

import tomllib

ROOT = Path(__file__).resolve().parents[2]
WIDTH = 100
LIST = tomllib.loads((ROOT / "api/surface.toml").read_text())
ENUMS = {enum["name"]: enum for enum in LIST["enum"]}

# Types: in C, in C++, in Python.
TYPES = {
    "bool": ("int32_t", "bool", "bool"),
    "maybe": ("int32_t", "std::optional<bool>", "bool | None"),
    "int": ("int32_t", "int", "int"),
    "seed": ("uint64_t", "std::uint64_t", "int | tuple[int, int] | None"),
    "real": ("double", "double", "float"),
    "text": ("const char*", "std::string", "str"),
    "path": ("const char*", "std::string", "str | os.PathLike[str] | None"),
    "latency": ("const char*", "int", "int | str"),
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


def of_batch(option):
    """What an option of an evaluation has in common with the option of its batches."""
    if option.get("of") != "environment":
        return {}
    batch = next(one for one in LIST["option"] if one["name"] == option["name"])
    shared = ("type", "default", "meaning", "c", "python", "signature")
    return {key: batch[key] for key in shared if key in batch}


EVALUATION = [completed({**of_batch(o), **o}) for o in LIST["evaluation_option"]]

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


# --- names ---


def enumerator(name):
    return "k" + camel(name)


def constant(enum, name):
    prefix = re.sub("_MODE$", "", enum["name"].upper())
    return f"ENGRAM_{prefix}_{re.sub('[+-]', '_', name.upper())}"
