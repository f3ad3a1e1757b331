"""The first thing that docs/python.md shows."""

from __future__ import annotations

from pathlib import Path

PAGE = Path(__file__).resolve().parents[2] / "docs" / "python.md"


def test_the_quick_start_succeeds(capsys):
    code = PAGE.read_text().split("```python\n")[1].split("```")[0]
    assert "num_envs=256" in code
    exec(compile(code.replace("256", "16"), "quick start", "exec"), {})
    assert capsys.readouterr().out == "1.0 of 16 episodes succeeded\n"
