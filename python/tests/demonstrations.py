"""Demonstrations of a few tasks, converted to all formats, for the tests that read them."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from engram.datasets import DemonstrationFolder

# Seven families; two of them are planned, and the last names an angle in its instruction.
IDS = (
    "RememberColor3-VLA-v0",
    "ShellGameTouch-VLA-v0",
    "FindImposterShape3-VLA-v0",
    "InterceptSlow-VLA-v0",
    "BlinkCountButtonPressEasy-VLA-v0",
    "TraceShapeEasy-VLA-v0",
    "RotateLenientPos-VLA-v0",
)
EPISODES = 2
SEED = 4_242_424_242  # more than 32 bits hold
COMMAND = [sys.executable, "-m", "engram"]


@pytest.fixture(scope="session")
def demonstrations(tmp_path_factory) -> Path:
    """A folder with demonstrations in all three formats."""
    for module in ("pyarrow", "av", "google_crc32c", "PIL", "pandas"):
        pytest.importorskip(module)
    folder = tmp_path_factory.mktemp("datasets")
    subprocess.run(
        [*COMMAND, "collect", *IDS, f"--episodes={EPISODES}", f"--seed={SEED}", "--out", folder],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    # In processes of their own: video libraries of several packages conflict at exit.
    for arguments in (["rlds", folder], ["lerobot", folder]):
        subprocess.run([sys.executable, "-m", "engram.datasets", *arguments], check=True)
    return folder


@pytest.fixture(params=IDS)
def folder(demonstrations, request) -> DemonstrationFolder:
    """The demonstrations of each task in turn."""
    from engram.datasets import find_folders

    return find_folders(demonstrations, [request.param])[0]
