"""Code that follows from the queries, in C, C++ and Python's extension."""

from math import prod

from cpp import call
from table import LIST, comment

GENERATED = [query for query in LIST["query"] if query["form"] != "hand"]
# Types of arguments: in C, in C++.
TYPES = {"text": ("const char*", "const std::string&"), "int": ("int32_t", "int")}
COPIES = "Copies as engram_instruction does"
NULLS = "NULL: not wanted. Refused with ENGRAM_BAD_STATE before the first reset"
EMPTY = "Empty spans are left out. Throws Error for other lengths, and before the first reset"


def of_form(form):
    return [query for query in GENERATED if query["form"] == form]


def meaning(query):
    return (
        query["meaning"] + "." + " Privileged: not for policies." * query.get("privileged", False)
    )


def parameters(query, language):
    """Arguments and outputs, as a function takes them."""
    result = [f"{TYPES[a['type']][language]} {a['name']}" for a in query.get("arguments", [])]
    if query["form"] == "text":
        c = ["int32_t index", "char* text", "size_t capacity", "size_t* length"]
        return c if language == 0 else ["int env"]
    if language == 1 and "struct" in query:
        return [*result, f"const {query['struct']}& out"]
    kind = "float*" if language == 0 else "std::span<float>"
    return result + [f"{kind} {output['name']}" for output in query["outputs"]]


def c_function(query, indent="", end=");", prefix=""):
    head = f"{indent}{prefix}engram_status engram_{query['name']}("
    return call(head, ["engram_env* env", *parameters(query, 0)], end)


def c_declarations(form):
    def lines(indent):
        result = []
        for query in of_form(form):
            about = f"{meaning(query)} {COPIES if form == 'text' else NULLS}."
            result += comment(indent, about, "/** ")
            result.append(c_function(query, indent, prefix="ENGRAM_API "))
        return result

    return lines


def includes(indent):
    return sorted(f'#include "{query["header"]}"' for query in of_form("text"))


def c_definitions(indent):
    result = []
    for query in GENERATED:
        result += ["", c_function(query, end=") {")]
        if query["form"] == "text":
            given = ["env", "index", "text", "capacity", "length", f"engram::{query['engine']}"]
            result.append(call("  return text_query(", given))
        else:
            result += array_body(query)
        result.append("}")
    return result[1:]


def array_body(query):
    texts = [a["name"] for a in query.get("arguments", []) if a["type"] == "text"]
    result = [f'  if ({name} == nullptr) return refuse_null("{name}");' for name in texts]
    spans = [f"rows(of, {o['name']}, {prod(o['shape'])})" for o in query["outputs"]]
    if "struct" in query:
        named = [f".{o['name']} = {span}" for o, span in zip(query["outputs"], spans)]
        spans = ["{" + ", ".join(named) + "}"]
    given = [a["name"] for a in query.get("arguments", [])]
    result.append("  return with_env(env, [&](engram_env& of) {")
    result.append(call(f"    of.queries.{query['name']}(", given + spans))
    return [*result, "  });"]


def cpp_declarations(form):
    def lines(indent):
        result = []
        for query in of_form(form):
            about = meaning(query) + (f" {EMPTY}." if form == "arrays" else "")
            result += comment(indent, about, "/// ")
            kind = "std::string" if form == "text" else "void"
            head = f"{indent}{kind} {query['name']}("
            result.append(call(head, parameters(query, 1), ") const;"))
        return result

    return lines


def cpp_definitions(indent):
    result = []
    for query in GENERATED:
        kind = "std::string" if query["form"] == "text" else "void"
        head = f"inline {kind} VectorEnv::{query['name']}("
        result += ["", call(head, parameters(query, 1), ") const {")]
        if query["form"] == "text":
            result.append(f"  return detail::copied(handle(), env, engram_{query['name']});")
        else:
            given = [converted(argument) for argument in query.get("arguments", [])]
            at = "out." if "struct" in query else ""
            for output in query["outputs"]:
                name, width = output["name"], prod(output["shape"])
                given.append(f'rows("{name}", {at}{name}, {width})')
            head = f"  detail::check(engram_{query['name']}("
            result.append(call(head, ["handle()", *given], "));"))
        result.append("}")
    return result[1:]


def converted(argument):
    name = argument["name"]
    return f"detail::c_text({name})" if argument["type"] == "text" else name


def extension(indent):
    """Array queries of Python's batch."""
    result = []
    for query in of_form("arrays"):
        name, arguments = query["name"], query.get("arguments", [])
        given = [f"{TYPES[a['type']][1]} {a['name']}" for a in arguments]
        result += ["", call(f"nb::tuple {name}(", ["const Batch& batch", *given], ") {")]
        # Texts are converted before the batch works, without Python's lock.
        texts = [a["name"] for a in arguments if a["type"] == "text"]
        result += [f"  const char* const {text}_text = c_text({text});" for text in texts]
        names = [a["name"] + "_text" * (a["type"] == "text") for a in arguments]
        outs = [f"out[{i}]" for i in range(len(query["outputs"]))]
        shapes = ["{" + ", ".join(map(str, o["shape"])) + "}" for o in query["outputs"]]
        capture = "[&]" if arguments else "[]"
        head = f"  return batch.arrays({{{', '.join(shapes)}}}, {capture}"
        result.append(f"{head}(engram_env* env, float* const* out) {{")
        result.append(call(f"    return engram_{name}(", ["env", *names, *outs]))
        result += ["  });", "}"]
    return result[1:]


def bindings(indent):
    """Methods of Python's batch."""
    result = []
    for query in GENERATED:
        name = query["name"]
        method, keys = f"&{name}", [a["name"] for a in query.get("arguments", [])]
        if query["form"] == "text":
            method, keys = f"&Batch::text_query<&engram_{name}>", ["index"]
        named = "".join(f', "{key}"_a' for key in keys)
        result.append(f'{indent}.def("{name}", {method}{named})')
    return result


def reference(indent):
    return [f"{indent}.. doxygenfunction:: engram_{query['name']}" for query in GENERATED]


def page(indent):
    """The table of docs/evaluation.md."""
    rows = []
    for query in LIST["query"]:
        privileged = "yes" if query.get("privileged") else "no"
        if "page" in query:
            rows.append(f"| `{query['name']}` | {privileged} | {query['page']} |")
    return ["| query | privileged | value |", "| --- | --- | --- |", *rows]
