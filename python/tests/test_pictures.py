"""Pictures of README.md and docs: each is what its command draws, to the pixel."""

from __future__ import annotations

import importlib.util
import re
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

ROOT = Path(__file__).resolve().parents[2]


def sheets() -> dict[str, str]:
    """Names and arguments of the sheets of docs/pictures/tasks."""
    spec = importlib.util.spec_from_file_location("pictures", ROOT / "tools/pages/pictures.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    found: dict[str, str] = module.SHEETS
    return found


def assert_drawn(picture: Path, arguments: list[str], folder: Path) -> None:
    """Compares pixels: libraries of PNG compress them differently."""
    out = folder / "drawn.png"
    command = [sys.executable, "-m", "engram", "record", *arguments, "--out", str(out)]
    run = subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=300
    )
    assert run.returncode == 0, run.stderr
    with Image.open(picture) as shown, Image.open(out) as drawn:
        assert np.array_equal(np.asarray(shown), np.asarray(drawn))


def test_the_picture_of_the_readme_is_what_its_command_draws(tmp_path: Path) -> None:
    readme = (ROOT / "README.md").read_text()
    block = re.search(r"The picture above was made by\n\n```sh\n(.*?)```", readme, re.DOTALL)
    assert block is not None
    words = shlex.split(block[1].replace("\\\n", " "))
    assert words[:2] == ["build/release/engram", "record"]
    out = words.index("--out")
    picture = re.search(r"!\[[^]]*\]\((\S+)\)", readme)
    assert picture is not None
    assert_drawn(ROOT / picture[1], words[2:out] + words[out + 2 :], tmp_path)


@pytest.mark.parametrize("name", sheets())
def test_sheets_are_what_their_commands_draw(name: str, tmp_path: Path) -> None:
    assert_drawn(ROOT / f"docs/pictures/tasks/{name}.png", sheets()[name].split(), tmp_path)
