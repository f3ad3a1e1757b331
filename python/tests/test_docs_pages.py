"""Python code of the quick start and the how-tos runs unchanged."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from engram.envs.compat import GYMNASIUM_1

DOCS = Path(__file__).parents[2] / "docs"
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize(
    "page", ["quick_start.md", "how_to/train.md", "how_to/evaluate.md", "how_to/collect.md"]
)
def test_its_python_runs(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    if not GYMNASIUM_1:
        pytest.skip("pages use autoreset modes that Gymnasium 0.29 lacks")
    monkeypatch.chdir(tmp_path)  # results are written
    blocks = BLOCK.findall((DOCS / page).read_text())
    assert blocks
    names: dict[str, object] = {"__name__": "__main__"}
    for block in blocks:  # each goes on where the one before it ended
        exec(compile(block, page, "exec"), names)
    printed = capsys.readouterr().out
    if page == "quick_start.md":
        assert "success: 1.0" in printed
        assert "(64, 128, 128, 6) (64, 7)" in printed
