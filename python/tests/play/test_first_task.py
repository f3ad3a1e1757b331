"""`engram play ID` begins with that task."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from doc_blocks import ROOT
from play_server import serving

OWN = ROOT / "python/examples/own_tasks/keep_track.py"


@pytest.mark.parametrize(
    ("given", "id"),
    [("RememberColor9-VLA-v0", "RememberColor9-VLA-v0"), (f"{OWN}:KeepTrack4-v0", "KeepTrack4-v0")],
)
def test_the_page_is_told_the_id(given: str, id: str, tmp_path: Path) -> None:
    with serving(tmp_path, given, command=("engram", "play")) as server, server.page() as page:
        assert page.receive("hello")["task"] == id
        page.play(id, 1)


def test_an_unknown_id_is_refused() -> None:
    words = [sys.executable, "-m", "engram", "play", "--no-open", "RememberColor-v0"]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "RememberColor-v0" in done.stderr
    assert "Traceback" not in done.stderr
