"""Code and texts that follow from the list of options, in Python and the docs."""

from table import (
    CONVERTED,
    ENUMS,
    LIST,
    OPTIONS,
    TYPES,
    WIDTH,
    allowed,
    any_of,
    camel,
    default_in_words,
    ordered,
    sentence,
    wrapped,
)


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
        result += [
            "",
            "",
            f"class {head}, total=False):",
            f'    """Keywords {about}, but for obs_mode."""',
            "",
        ]
        for option in keywords():
            taken = option["python"] not in ("num_envs", "obs_mode")
            if taken and option.get("batch", False) == of_batch:
                result.append(f"    {option['python']}: {typed(option)[0]}")
    return [*result, "", ""]


def default_in_python(option):
    if "python_default" in option:
        return option["python_default"]
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
