"""Sources of custom tasks by content."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import pytest

import engram
from engram.kit.files import load_file
from engram.kit.registration import definitions
from engram.kit.sources import source_of

FILE = """
import engram
import lamp_parts.colors
from lamp_sizes import SIZE


class Lamp(engram.Task):
    def build(self):
        self.cube = self.add_prop(engram.kit.Cube("cube", color=lamp_parts.colors.COLOR))

    def reset(self):
        self.place(self.cube, (0, 0))

    def evaluate(self):
        self.success[:] = self.elapsed >= SIZE

    def reward(self):
        return self.success * 1.0


engram.register_task(Lamp, "LampSource-v0", 10, "Wait.")
"""


def write(folder: Path, size: int = 3, color: str = "red", extra: str = "") -> Path:
    (folder / "lamp_parts").mkdir(parents=True, exist_ok=True)
    (folder / "lamp_parts" / "__init__.py").write_text("")
    (folder / "lamp_parts" / "colors.py").write_text(f'COLOR = "{color}"\n')
    (folder / "lamp_sizes.py").write_text(f"SIZE = {size}\n")
    (folder / "not_imported.py").write_text(extra)
    (folder / "lamps.py").write_text(FILE)
    return folder / "lamps.py"


def source(file: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    for name in list(sys.modules):
        if name.startswith("lamp"):
            monkeypatch.delitem(sys.modules, name)
    load_file(file)
    found: str = json.loads(definitions["LampSource-v0"][0])["source"]
    return found


def test_a_source_is_of_the_file_and_of_what_it_imports(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = source(write(tmp_path / "a"), monkeypatch)
    assert len(first) == 64
    # Neither the folder nor files beside it count.
    assert source(write(tmp_path / "b", extra="x = 1"), monkeypatch) == first
    sizes = source(write(tmp_path / "c", size=4), monkeypatch)
    colors = source(write(tmp_path / "d", color="blue"), monkeypatch)
    edited = write(tmp_path / "e")
    edited.write_text(FILE.replace("1.0", "2.0"))
    assert len({first, sizes, colors, source(edited, monkeypatch)}) == 4


def test_bases_of_a_class_count(tmp_path: Path) -> None:
    both = []
    for number in (1, 2):
        base = tmp_path / f"base_{number}.py"
        base.write_text(f"import engram\n\n\nclass Base(engram.Task):\n    number = {number}\n")
        spec = importlib.util.spec_from_file_location(f"base_{number}", base)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        sys.modules[spec.name] = module
        spec.loader.exec_module(module)
        both.append(source_of(type("Lamp", (module.Base,), {})))
    assert both[0] != both[1]


def test_a_class_without_source_has_none() -> None:
    space: dict[str, object] = {"engram": engram, "__name__": "nowhere"}
    exec("class Lamp(engram.Task):\n    pass\n", space)
    lamp = space["Lamp"]
    assert isinstance(lamp, type)
    assert source_of(lamp) == ""


WAITING = """
import engram
from wait_steps import STEPS


class Waiting(engram.Task):
    def build(self):
        self.cube = self.add_prop(engram.kit.Cube("cube", color="red"))

    def reset(self):
        self.place(self.cube, (0, 0))

    def evaluate(self):
        self.success[:] = self.elapsed >= STEPS

    def reward(self):
        return self.success * 1.0


engram.register_task(Waiting, "Waiting-v0", 10, "Wait.")
"""


def engram_command(*words: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "engram", *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)


def test_results_of_an_edited_file_are_neither_resumed_nor_compared(tmp_path: Path) -> None:
    results = []
    for steps in (3, 20):
        folder = tmp_path / str(steps)
        folder.mkdir()
        (folder / "wait_steps.py").write_text(f"STEPS = {steps}\n")
        (folder / "waiting.py").write_text(WAITING)
        run = engram_command("eval", f"{folder / 'waiting.py'}:Waiting-v0", "--policy", "zero",
                             "--episodes", 2, "--out", folder)  # fmt: skip
        assert run.returncode == 0, run.stderr
        results.append(next(folder.glob("*/*/settings.json")).parent)
    definitions = [
        json.loads((one / "settings.json").read_text())["definitions"]["Waiting-v0"]
        for one in results
    ]
    compared = engram_command("compare", *results)
    resumed = engram_command("eval", f"{tmp_path / '20' / 'waiting.py'}:Waiting-v0", "--policy",
                             "zero", "--episodes", 2, "--resume", results[0])  # fmt: skip
    for run in (compared, resumed):
        assert run.returncode == 2
        assert "task 'Waiting-v0' has two definitions" in run.stderr
        assert all(one[:8] in run.stderr for one in definitions)
