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
