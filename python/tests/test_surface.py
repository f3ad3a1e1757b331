"""The generator of the public surface, tools/surface."""

import importlib
import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[2] / "tools/surface"


@pytest.fixture
def module(monkeypatch):
    """Imports a module of the generator by name."""
    monkeypatch.syspath_prepend(str(FOLDER))
    names = [path.stem for path in FOLDER.glob("*.py")]
    yield importlib.import_module
    for name in names:
        sys.modules.pop(name, None)


def test_generated_blocks_are_up_to_date():
    subprocess.run([sys.executable, str(FOLDER), "--check"], check=True)


def test_blocks_are_replaced_between_their_marks(module):
    text = "a\n  // begin generated: b (by x)\n  old\n  // end generated\nz\n"
    blocks = {"b": lambda indent: [indent + "new  ", ""]}
    new = module("blocks").rewritten("file", text, blocks)
    assert new == "a\n  // begin generated: b (by x)\n  new\n\n  // end generated\nz\n"


def test_blocks_without_marks_and_marks_without_blocks_are_refused(module):
    rewritten = module("blocks").rewritten
    with pytest.raises(SystemExit, match="file: no block named b"):
        rewritten("file", "text", {"b": lambda indent: []})
    with pytest.raises(SystemExit, match="file: block c given, none of the table's"):
        rewritten("file", "# begin generated: c\n# end generated\n", {})


def test_layout_does_not_count(module):
    squeezed = module("blocks").squeezed
    assert squeezed('f(a, "one two");') == squeezed('f(a,\n  "one "\n  "two");')
    assert squeezed("f(a, b);") != squeezed("f(b, a);")


def test_every_key_of_results_has_one_option(module):
    table = module("table")
    for name in ("option", "evaluation_option", "evaluation_keyword", "keyword", "query"):
        names = [(entry["name"], str(entry.get("functions"))) for entry in table.LIST[name]]
        assert len(names) == len(set(names)), name
    keys = [option["key"] for option in table.EVALUATION if "key" in option]
    assert len(keys) == len(set(keys))
    flags = [option["flag"] for option in table.EVALUATION if "flag" in option]
    assert len(flags) == len(set(flags))


def test_orders_name_what_the_tables_have(module):
    table = module("table")
    order = table.LIST["order"]
    python = module("evaluation_python")
    for function in ("evaluate", "probe"):
        assert set(order[function]) == {o["python"] for o in python.keywords(function)}
    options = {option["name"] for option in table.OPTIONS}
    assert set(order["c"]) <= options


def test_a_query_of_a_text_is_one_call_in_each_language(module, monkeypatch):
    cpp, python = module("queries_cpp"), module("queries_python")
    query = {
        "name": "timing",
        "form": "text",
        "engine": "describe_timing",
        "header": "times.h",
        "meaning": "The time",
        "privileged": True,
        "summary": "The times.",
        "returns": "A dictionary.",
        "single": "The time.",
    }
    monkeypatch.setattr(cpp, "GENERATED", [query])
    monkeypatch.setattr(python, "METHODS", [query])
    c = "engram_status engram_timing(engram_env* env, int32_t index, char* text, size_t capacity, "
    about, declared = cpp.c_declarations("text")("")[0], cpp.c_declarations("text")("")[-1]
    assert about.startswith("/** The time. Privileged: not for policies. Copies as")
    assert declared == f"ENGRAM_API {c}size_t* length);"
    assert cpp.c_definitions("") == [
        f"{c}size_t* length) {{",
        "  return text_query(env, index, text, capacity, length, engram::describe_timing);",
        "}",
    ]
    assert cpp.includes("") == ['#include "times.h"']
    assert cpp.bindings("") == ['.def("timing", &Batch::text_query<&engram_timing>, "index"_a)']
    assert "def timing(self) -> list[dict[str, Any]]:" in python.mixin("")
    assert "    return self.batch.timing()[0]" in python.single("")


def test_a_query_of_arrays_knows_their_widths(module, monkeypatch):
    cpp = module("queries_cpp")
    outputs = [{"name": "speed", "shape": [2, 3]}]
    arguments = [{"name": "frame", "type": "text"}]
    query = {"name": "speeds", "form": "arrays", "outputs": outputs, "arguments": arguments}
    monkeypatch.setattr(cpp, "GENERATED", [query])
    assert cpp.c_definitions("") == [
        "engram_status engram_speeds(engram_env* env, const char* frame, float* speed) {",
        '  if (frame == nullptr) return refuse_null("frame");',
        "  return with_env(env, [&](engram_env& of) {",
        "    of.queries.speeds(frame, rows(of, speed, 6));",
        "  });",
        "}",
    ]
    assert "  return batch.arrays({{2, 3}}, [&](engram_env* env, float* const* out) {" in (
        cpp.extension("")
    )


def test_an_option_of_a_run_is_said_in_every_layer(module, monkeypatch):
    cpp = module("evaluation_cpp")
    option = {
        "name": "pause",
        "core": "pause",
        "type": "int",
        "default": 2,
        "low": 1,
        "high": 10_000,
        "meaning": "steps of rest",
        "of": "run",
        "key": "pause",
        "flag": "--pause",
        "commands": ["eval"],
        "cli": 'Rest, "idle" steps',
    }
    for name in ("EVALUATION", "OF_C", "OF_RUN", "WRITTEN"):
        monkeypatch.setattr(cpp, name, [option])
    assert cpp.init("") == ["options->pause = 2;"]
    assert cpp.constants("") == ["inline constexpr int kMaxPause = 10'000;"]
    assert cpp.run_fields("") == ["// Steps of rest. 1 to 10,000.", "int pause = 2;"]
    assert cpp.conversions("") == [
        'convert("pause", options.pause, 1, engram::kMaxPause, settings.pause);'
    ]
    assert cpp.reads("") == ['read(document, "pause", 1, kMaxPause, settings.pause);']
    assert cpp.own_keys(first=False)("") == [
        'add("pause", settings.pause != usual.pause, settings.pause);'
    ]
    assert cpp.flags("")[1] == (
        '  add(command, "--pause", 1, kMaxPause, run.pause, "Rest, \\"idle\\" steps");'
    )
