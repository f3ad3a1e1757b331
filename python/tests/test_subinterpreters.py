"""Subinterpreters, in which engram's calls would never return."""

from __future__ import annotations

import subprocess
import sys

import pytest

pytest.importorskip("_xxsubinterpreters", reason="Python 3.10 to 3.12 have this module")

INNER = """
try:
    import engram
    print("imported", flush=True)
except ImportError as error:
    print("refused:", error, flush=True)
"""

PROGRAM = """
import sys
import _xxsubinterpreters as interpreters
if sys.argv[1] == "first":
    import engram
inner = interpreters.create()
interpreters.run_string(inner, sys.argv[2])
interpreters.destroy(inner)
import engram
env = engram.make_vec("RememberColor3-VLA-v0", num_envs=2, obs_mode="state")
env.reset(seed=1)
env.step(env.act("zero"))
env.close()
print("stepped")
"""


@pytest.mark.parametrize("order", ["first", "after"])
def test_a_subinterpreter_is_refused_at_import(order: str) -> None:
    result = subprocess.run(
        [sys.executable, "-c", PROGRAM, order, INNER],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    refusal, stepped = result.stdout.splitlines()
    assert refusal.startswith("refused:")
    assert stepped == "stepped"
