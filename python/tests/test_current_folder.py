"""Commands import nothing from the current folder, which has a module for every name there is."""

from __future__ import annotations

import importlib.metadata
import os
import subprocess
import sys
from pathlib import Path

import pytest
from play_server import play_oracle, serving

TASK = "RememberColor3-VLA-v0"
COMMAND = Path(sys.executable).with_name("engram")
NAMES = sorted(
    name
    for name in {
        *sys.stdlib_module_names,
        *importlib.metadata.packages_distributions(),
        *("engram", "sitecustomize", "usercustomize", "video"),
    }
    if name.isidentifier()
)
# What needs no longer than a moment; the others show their help.
COMMANDS = (
    "list",
    f"info {TASK}",
    f"rollout {TASK} --num-envs 1 --steps 2",
    f"eval {TASK} --episodes 1",
    f"collect {TASK} --episodes 1 --out data",
    f"record {TASK} --steps 2 --size 64 --out film.mp4",
    f"record {TASK} --steps 2 --size 64 --out film.gif",
    f"record {TASK} --sheet 2 --size 64 --out sheet.png",
    "play --help",
    "serve --help",
    "bench --help",
    "soak --help",
    f"verify {TASK} --obs state --steps 1",
    "doctor",
)
# -P leaves out the current folder, so nothing that the modules start may bring it back.
MODULES = (
    "engram list",
    f"engram record {TASK} --steps 2 --size 64 --out film.mp4",
    "engram.datasets rlds data",
    "engram.datasets lerobot data",
    "engram.datasets replay data",
    "engram.play --help",
    "engram.mikasa --help",
    "engram_learners.scores --help",
    "engram.servers serve --help",
)


@pytest.fixture
def planted(tmp_path: Path) -> Path:
    """A folder with modules that leave a file when they are imported."""
    for name in NAMES:
        (tmp_path / f"{name}.py").write_text("open(__file__ + '.imported', 'w').close()\n")
    return tmp_path


def imported(folder: Path) -> list[str]:
    return sorted(file.name for file in folder.glob("*.imported"))


def run(folder: Path, *words: object, **environment: str) -> None:
    done = subprocess.run(
        [str(word) for word in words],
        capture_output=True,
        text=True,
        cwd=folder,
        env={key: value for key, value in os.environ.items() if key != "PYTHONPATH"} | environment,
        check=False,
    )
    assert imported(folder) == []
    assert done.returncode == 0, done.stderr


def test_planted_modules_would_be_seen(planted):
    subprocess.run([sys.executable, "-c", "import av, engram, numpy"], cwd=planted, check=True)
    assert imported(planted) == [f"{name}.py.imported" for name in ("av", "engram", "numpy")]


@pytest.mark.parametrize("words", COMMANDS)
def test_the_command_imports_none_of_them(planted, words):
    run(planted, COMMAND, *words.split())
    for written in planted.glob("film.*"):
        assert written.stat().st_size > 500


def test_the_server_imports_none_of_them(planted):
    out = planted / "played"
    command = ("play", "--policy-command", "true")
    with serving(out, program=[COMMAND], command=command, cwd=planted) as server:
        assert len(server.get("tasks.json")) >= 97
        with server.page() as page:
            play_oracle(page, TASK, 9)
            page.send("save")
            page.receive("saved")
        assert imported(planted) == []
    assert [*out.rglob("*.npz")]


@pytest.mark.parametrize("protocol", ["openpi", "gr00t", "act"])
def test_policy_servers_and_their_clients_import_none_of_them(planted, protocol):
    words = ("serve", "--policy", "oracle", "--protocol", protocol, "--port", "0")
    with subprocess.Popen(
        [COMMAND, *words], cwd=planted, stdout=subprocess.PIPE, text=True
    ) as process:
        url = process.stdout.readline().split()[-1]
        server = ("--policy-server", url, "--tell-episodes")
        run(planted, COMMAND, "eval", TASK, "--episodes", "1", *server)
        process.terminate()
    assert imported(planted) == []


@pytest.mark.skipif(sys.version_info < (3, 11), reason="Python 3.10 has no option -P")
@pytest.mark.parametrize("words", MODULES)
def test_modules_import_none_of_them_with_the_option_of_python(planted, words):
    if "data" in words.split():
        run(planted, COMMAND, *f"collect {TASK} --episodes 1 --out data".split())
    run(planted, sys.executable, "-P", "-m", *words.split())


def test_what_python_starts_keeps_the_current_folder(tmp_path):
    """Modules of a policy's own lie there."""
    (tmp_path / "my_part.py").write_text("open('used', 'w').close()\n")
    command = f"{sys.executable} -c 'import my_part'"
    subprocess.run(
        [COMMAND, "record", TASK, "--out", "film.mp4", "--policy-command", command],
        cwd=tmp_path,
        capture_output=True,
        check=False,
    )
    assert (tmp_path / "used").exists()
