"""Tasks of a library, which the build of the C++ tests has compiled (docs/cpp_tasks.md)."""

from __future__ import annotations

import os
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest

import engram

LIBRARIES = Path(__file__).parents[2] / "build/release/tests/task_libraries"
LIBRARY = LIBRARIES / "libtouch_spot.so"
TASK = "TouchSpot-VLA-v0"

if not LIBRARY.exists():
    pytest.skip("scripts/build.sh has not compiled the libraries", allow_module_level=True)


def run(script: str, **variables: str) -> str:
    """What a process of its own prints: libraries stay loaded."""
    result = subprocess.run(
        [sys.executable, "-c", script],
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    return result.stdout.strip()


def test_tasks_of_a_library_are_made_and_registered_with_gymnasium():
    script = f"""
import gymnasium, engram
engram.load_tasks({str(LIBRARY)!r})
engram.load_tasks({str(LIBRARY)!r})
assert [task["id"] for task in engram.list()].count({TASK!r}) == 1
assert engram.describe({TASK!r})["family"] == "TouchSpot"
gymnasium.make("engram/{TASK}").reset(seed=1)
env = engram.make_vec({TASK!r}, 32, autoreset_mode="DISABLED")
env.reset(seed=1)
for _ in range(env.description["horizon"]):
    env.step(env.act("oracle"))
print(sum(sub_env.output("success_once") for sub_env in env.envs))
"""
    assert run(script) == "32"


def test_the_environment_variable_names_libraries():
    script = f"""
import gymnasium, engram
env = gymnasium.make("engram/{TASK}")
print(env.reset(seed=1)[0].shape)
"""
    assert run(script, ENGRAM_TASKS=f":{LIBRARY}").startswith("(")


def test_refusals_of_a_library_are_errors_of_engram():
    script = f"""
import engram
engram.load_tasks({str(LIBRARY)!r})
try:
    engram.make({TASK!r}, constants={{"GOAL_THRESH": 9.0}})
except engram.InvalidArgumentError as error:
    print(error)
"""
    assert "GOAL_THRESH" in run(script)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("no_entry", "without the function engram_task_library"),
        ("other_version", "made for engram '0.0.1', this is"),
        ("other_abi", "another ABI"),
        ("other_headers", "other headers"),
        ("taken_id", "taken, by a task of the benchmark"),
    ],
)
def test_libraries_that_do_not_fit_are_refused(name, message):
    file = LIBRARIES / f"lib{name}.so"
    with pytest.raises(engram.InvalidArgumentError, match=message) as refused:
        engram.load_tasks(file)
    assert str(file) in str(refused.value)


def test_files_that_are_no_libraries_are_refused(tmp_path):
    text = tmp_path / "libtext.so"
    text.write_text("no library")
    with pytest.raises(engram.InvalidArgumentError, match="not a library"):
        engram.load_tasks(text)
    with pytest.raises(engram.IoError, match="cannot be read"):
        engram.load_tasks(tmp_path / "none.so")
    with closing(engram.make_vec("RememberColor3-VLA-v0", 1)) as env:
        env.reset()
