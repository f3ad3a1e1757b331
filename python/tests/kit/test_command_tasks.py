"""Tasks of a user's file in the engram command."""

from __future__ import annotations

import ctypes
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

FILE = """
import numpy as np
import engram
from engram import kit


class Wait(engram.Task):
    GOAL = kit.Integer(6, low=1, high=9, text="control steps")
    termination = "success"

    def build(self):
        self.cube = self.add_prop(kit.Cube("cube", color="red"))
        self.draw_real("cube_y", -0.2, 0.2, unit="m", text="y of the cube")
        self.remember("count", int, text="steps so far")

    def reset(self):
        zero = np.zeros(self.n)
        self.place(self.cube, np.stack([zero, self.cube_y], axis=1))

    def advance(self):
        self.count += 1

    def evaluate(self):
        self.success[:] = self.count > self.GOAL
        TRICK

    def reward(self):
        return np.where(self.success, 1, 0.1 * self.count / self.GOAL)

    def oracle(self):
        self.rest()

    def blind(self):
        self.rest()


engram.register_task(Wait, "Wait-v0", 12, "Wait.")
"""


def write(folder: Path, trick: str = "pass") -> Path:
    path = folder / "waiting.py"
    path.write_text(FILE.replace("TRICK", trick))
    return path


def words(*given: object) -> list[str]:
    return [sys.executable, "-m", "engram", *map(str, given)]


def run(*given: object, **variables: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(words(*given), capture_output=True, text=True, check=False, timeout=300,
                          env=with_variables(variables))  # fmt: skip


def with_variables(variables: dict[str, object]) -> dict[str, str]:
    return os.environ | {key: str(one) for key, one in variables.items()}


def results(done: subprocess.CompletedProcess[str]) -> dict:
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_evaluates_a_task_of_a_file(tmp_path: Path) -> None:
    file = write(tmp_path)
    by_name = results(run("eval", f"{file}:Wait-v0", "--episodes", 10, "--json"))
    by_option = results(run("--tasks", file, "eval", "Wait-v0", "--episodes", 10, "--json"))
    assert by_name["summary"]["per_task_sr"] == {"Wait-v0": 1.0}
    assert by_name["tasks"][0]["returns"] == by_option["tasks"][0]["returns"]


def test_results_do_not_depend_on_threads(tmp_path: Path) -> None:
    file = write(tmp_path)
    hashes = [
        results(
            run("rollout", f"{file}:Wait-v0", "--set", "GOAL=4", "--num-envs", 3, "--steps", 30,
                "--threads", threads, "--hash", "--policy", "random", "--json")
        )["hash"]
        for threads in (1, 2)
    ]  # fmt: skip
    assert hashes[0] == hashes[1]


def test_collects_and_records_a_task_of_a_file(tmp_path: Path) -> None:
    file = write(tmp_path)
    target = f"{file}:Wait-v0"
    done = run("collect", target, "--episodes", 3, "--out", tmp_path / "demos")
    assert done.returncode == 0, done.stderr
    episodes = sorted((tmp_path / "demos").rglob("*.npz"))
    assert len(episodes) == 3
    with np.load(episodes[0]) as data:
        assert data["success"][-1]
    done = run("record", target, "--sheet", 2, "--out", tmp_path / "sheet.png")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "sheet.png").stat().st_size > 1000


@pytest.mark.parametrize("command", ["eval", "collect", "probe"])
def test_shards_of_different_definitions_do_not_merge(command: str, tmp_path: Path) -> None:
    out = tmp_path / "out"

    def play(shard: str) -> None:
        line = [command, f"{file}:Wait-v0", "--episodes", 4, "--shard", shard, "--out", out]
        done = run(*line, *(["--probes", "capacity"] if command == "probe" else []))
        assert done.returncode == 0, done.stderr

    file = write(tmp_path)
    play("1/2")
    write(tmp_path, trick="pass  # otherwise")
    play("2/2")
    done = run("--tasks", file, "merge", out)
    assert done.returncode == 2
    assert "one run has one of them" in done.stderr
    assert "Wait-v0" in done.stderr or "definition" in done.stderr
    write(tmp_path)
    shutil.rmtree(out / "shard-2-of-2")
    play("2/2")
    done = run("--tasks", file, "merge", out)
    assert done.returncode == 0, done.stderr


def test_info_and_list_know_it(tmp_path: Path) -> None:
    file = write(tmp_path)
    info = results(run("info", f"{file}:Wait-v0", "--json"))
    assert info["horizon"] == 12
    assert "GOAL" in [one["name"] for one in info["changeable"]]
    listed = results(run("--tasks", file, "list", "--json"))
    assert listed[-1]["id"] == "Wait-v0"


IN_PYTHON = """
import gymnasium
import engram

assert "Wait-v0" in [task["id"] for task in engram.list()]
assert "engram/Wait-Short-v0" in gymnasium.registry
env = engram.make_vec("Wait-Short-v0", 2, autoreset_mode="DISABLED", after_end="hold")
env.reset(seed=1)
for _ in range(4):
    *_, info = env.step(env.act("oracle"))
print(info["success"].all())
"""


def test_engram_tasks_names_files_for_the_command_and_for_python(tmp_path: Path) -> None:
    variant = {"id": "Wait-Short-v0", "base": "Wait-v0", "constants": {"GOAL": 2}}
    variants = tmp_path / "variants.json"
    variants.write_text(json.dumps({"variants": [variant]}))
    named = {"ENGRAM_TASKS": f":{write(tmp_path)}:", "ENGRAM_VARIANTS": variants}
    listed = results(run("list", "--json", **named))
    assert [one["id"] for one in listed[-2:]] == ["Wait-v0", "Wait-Short-v0"]
    done = results(run("eval", "Wait-Short-v0", "--episodes", 4, "--json", **named))
    assert done["summary"]["per_task_sr"] == {"Wait-Short-v0": 1.0}
    python = subprocess.run([sys.executable, "-c", IN_PYTHON], capture_output=True, text=True,
                            check=False, timeout=300, env=with_variables(named))  # fmt: skip
    assert python.stdout == "True\n", python.stderr


def test_a_file_of_engram_tasks_that_fails_says_why(tmp_path: Path) -> None:
    missing = run("list", ENGRAM_TASKS=tmp_path / "none.py")
    assert missing.returncode != 0
    assert "none.py: no such file" in missing.stderr


@pytest.mark.parametrize(
    ("trick", "reason"),
    [
        ("raise ValueError('the lamp is broken')", "ValueError: the lamp is broken"),
        ("import os; os._exit(3)", "its process has ended"),
        ("self.success[:] = np.ones(99)", "could not broadcast"),
    ],
)
def test_a_task_that_fails_ends_the_command_with_the_reason(
    tmp_path: Path, trick: str, reason: str
) -> None:
    done = run("eval", f"{write(tmp_path, trick)}:Wait-v0", "--episodes", 4)
    assert done.returncode == 1
    assert "task 'Wait-v0'" in done.stderr
    assert reason in done.stderr.splitlines()[-1]


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("raise OSError('no lamp')", "OSError: no lamp"),
        ("x = 1", "registers no task"),
        ("import engram_missing_module", "No module named"),
    ],
)
def test_a_file_that_cannot_be_used_is_refused(tmp_path: Path, text: str, reason: str) -> None:
    file = tmp_path / "wrong.py"
    file.write_text(text)
    done = run("eval", f"{file}:Wait-v0")
    assert done.returncode != 0
    assert reason in done.stderr.splitlines()[-1]
    missing = run("eval", f"{tmp_path / 'none.py'}:Wait-v0")
    assert missing.returncode != 0
    assert "no such file" in missing.stderr


def test_an_unknown_id_of_a_file_is_refused(tmp_path: Path) -> None:
    done = run("eval", f"{write(tmp_path)}:Weit-v0")
    assert done.returncode == 2
    assert "no task 'Weit-v0'; did you mean 'Wait-v0'?" in done.stderr


def test_ctrl_c_ends_a_task_that_does_not(tmp_path: Path) -> None:
    file = write(tmp_path, "import time; time.sleep(1e9)")
    with subprocess.Popen(words("eval", f"{file}:Wait-v0"), stderr=subprocess.PIPE) as process:
        time.sleep(6)
        assert process.poll() is None
        process.send_signal(signal.SIGINT)
        begin = time.monotonic()
        process.communicate(timeout=30)
        assert time.monotonic() - begin < 15
    assert process.returncode != 0


def test_what_a_file_prints_is_no_result(tmp_path: Path) -> None:
    file = write(tmp_path, "print('in a step')")
    done = run("eval", f"{file}:Wait-v0", "--episodes", 2, "--json")
    assert results(done)["summary"]["tasks"] == ["Wait-v0"]
    assert "in a step" in done.stderr


def test_no_process_stays_behind(tmp_path: Path) -> None:
    file = write(tmp_path)
    results(run("eval", f"{file}:Wait-v0", "--episodes", 6, "--json"))
    time.sleep(0.5)
    found = []
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit() or int(entry.name) == os.getpid():
            continue
        try:
            command = (entry / "cmdline").read_bytes()
        except OSError:
            continue
        if str(file).encode() in command:
            found.append(command)
    assert found == []


# Opens what it can of processes with a task file on their command line, and ends.
SPY = """
import os, pathlib, sys

lines = []
for process in pathlib.Path("/proc").glob("[0-9]*"):
    try:
        words = (process / "cmdline").read_bytes().split(bytes(1))
    except OSError:
        continue
    if not any(b"waiting.py" in word for word in words):
        continue
    name = "command" if words[0].endswith(b"engram") else "task"
    lines.append(f"{name} {process.name}")
    try:
        (process / "mem").open("rb").close()
        lines.append(f"{name} {process.name} memory")
    except OSError:
        pass
    try:
        for one in (process / "fd").iterdir():
            lines.append(f"{name} {process.name} {os.readlink(one)}")
    except OSError:
        pass
pathlib.Path(sys.argv[1]).write_text("\\n".join(lines))
sys.exit(3)
"""


def drop_capabilities() -> None:
    """Nothing is kept from root; without capabilities it is as any other user."""
    bounding_set_drop = 24
    for capability in range(64):
        ctypes.CDLL(None).prctl(bounding_set_drop, capability, 0, 0, 0)


def test_policies_of_a_sealed_run_cannot_open_processes_of_tasks(tmp_path: Path) -> None:
    file = write(tmp_path)
    spy, seen, secret = (tmp_path / name for name in ("spy.py", "seen", "secret"))
    spy.write_text(SPY)
    secret.write_text("a secret of this test, 0123456789abcdef")
    done = subprocess.run(
        words("eval", f"{file}:Wait-v0", "--episodes", 1, "--threads", 1, "--seed-file", secret,
              "--policy-command", f"{sys.executable} {spy} {seen}"),
        capture_output=True, text=True, check=False, timeout=300, preexec_fn=drop_capabilities,
    )  # fmt: skip
    found = seen.read_text().split("\n")
    processes = [line for line in found if len(line.split()) == 2]
    assert len(processes) >= 3, (found, done.stderr)  # the command, the task's process, its guard
    assert [line for line in found if line not in processes] == []
