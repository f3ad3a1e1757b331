"""Types for checkers, keys of descriptions, and texts of ``repr``."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import get_type_hints

import pytest
from conftest import registered_ids

import engram
from engram import typing as types

HERE = Path(__file__).parent / "typing"
MISTAKES = [
    number
    for number, line in enumerate((HERE / "mistakes.py").read_text().splitlines(), 1)
    if line.endswith("# mistake")
]


def run(*command: str, folder: Path) -> str:
    environment = {**os.environ, "PYTHONPATH": str(Path(engram.__file__).parents[1])}
    result = subprocess.run(
        [sys.executable, "-m", *command],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert not result.stderr, result.stderr
    return result.stdout


def mypy(files: list[Path], folder: Path) -> Iterator[tuple[str, int]]:
    """File and line of each error that mypy finds."""
    options = ("--strict", "--no-error-summary", "--output=json", "--config-file=")
    # Without errors inside the package itself, as for an installed one.
    found = run("mypy", *options, "--follow-imports=silent", *map(str, files), folder=folder)
    for message in map(json.loads, found.splitlines()):
        if message["severity"] == "error":
            yield Path(message["file"]).name, message["line"]


def pyright(files: list[Path], folder: Path) -> Iterator[tuple[str, int]]:
    """File and line of each error that pyright finds."""
    options = ("--outputjson", "--pythonpath", sys.executable)
    found = json.loads(run("pyright", *options, *map(str, files), folder=folder))
    for message in found["generalDiagnostics"]:
        if message["severity"] == "error":
            yield Path(message["file"]).name, message["range"]["start"]["line"] + 1


@pytest.mark.parametrize("checker", [mypy, pyright])
def test_checkers_find_all_mistakes_and_no_others(checker, tmp_path):
    pytest.importorskip(checker.__name__)
    assert len(MISTAKES) == 10
    found = set(checker([HERE / "mistakes.py", HERE / "correct.py"], tmp_path))
    assert sorted(found) == [("mistakes.py", line) for line in MISTAKES]


def keys_of(cls: type) -> set[str]:
    return set(get_type_hints(cls))


@pytest.mark.parametrize("obs_mode", ["state", "rgb", "objects"])
def test_descriptions_have_the_keys_of_their_types(obs_mode):
    parts = {
        "draws": types.Draw,
        "options": types.Option,
        "changeable": types.Constant,
        "phases": types.Phase,
        "state_fields": types.Field,
        "proprio": types.Field,
        "outputs": types.Output,
        "props": types.Prop,
    }
    for id in registered_ids()[::6]:
        described = engram.describe(id, obs_mode=obs_mode)
        assert set(described) == keys_of(types.TaskDescription), id
        for name, cls in parts.items():
            for part in described[name]:
                assert cls.__required_keys__ <= set(part) <= keys_of(cls), (id, name)
        if described["choices"] is not None:
            assert set(described["choices"]) == keys_of(types.Choices)
        for space in described["action_spaces"].values():
            assert set(space) == keys_of(types.ActionSpace)
    assert all(set(task) == keys_of(types.TaskSummary) for task in engram.list())


def test_dir_lists_the_public_names():
    assert set(engram.__all__) <= set(dir(engram))
    assert {"VectorEnv", "Env", "AutoresetMode", "make", "describe"} <= set(dir(engram))
    with pytest.raises(AttributeError, match="nothing"):
        engram.nothing  # noqa: B018


def test_repr_names_task_and_modes(make):
    env = make(num_envs=3, obs_mode="objects", autoreset_mode="SAME_STEP")
    for part in (
        "engram.VectorEnv",
        "RememberColor3-VLA-v0",
        "num_envs=3",
        "obs_mode=objects",
        "reward_mode=normalized_dense",
        "control_mode=pd_ee_delta_pose",
        "autoreset_mode=SAME_STEP",
    ):
        assert part in repr(env)
    assert repr(env) in repr(env.envs[2])
    assert "environment 2" in repr(env.envs[2])
    env.close()
    assert "closed" in repr(env)
    single = engram.make("ShellGameTouch-VLA-v0", obs_mode="rgb")
    assert repr(single) == str(single)
    assert "engram.Env ShellGameTouch-VLA-v0, obs_mode=rgb" in repr(single)
    single.close()
