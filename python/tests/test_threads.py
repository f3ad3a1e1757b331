"""Threads on one batch, threads that still work when the interpreter ends, and forked processes."""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap
import threading

import numpy as np
import pytest
from conftest import TASK

import engram

ACTIONS = np.zeros((4, 7), np.float32)
AT_WORK = {
    "step": """
        env = engram.make_vec(TASK, 8, threads=2)
        env.reset()
        while True:
            env.step(env.act("random"))
    """,
    "step_async": """
        env = engram.make_vec(TASK, 8, threads=2)
        env.reset()
        while True:
            env.step_async(np.zeros((8, 7), np.float32))
            env.step_wait()
    """,
    "pictures": """
        env = engram.make_vec(TASK, 4, threads=2, obs_mode="rgb")
        env.reset()
        while True:
            env.step(env.act("random"))
    """,
    "make": """
        while True:
            env = engram.make_vec(TASK, 2, threads=2)
            env.reset()
            env.close()
    """,
    "evaluate": """
        def policy(observation):
            return np.zeros((len(observation["instruction"]), 7), np.float32)

        while True:
            engram.evaluate(policy, TASK, obs="state", threads=2)
    """,
}


def run(program: str) -> subprocess.CompletedProcess:
    return subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=300, check=False
    )


def with_threads(work: str, rest: str) -> str:
    """A program with two threads at work, and what the main thread does."""
    return (
        "import os, sys, threading, time\nimport numpy as np\nimport engram\n"
        "TASK = 'RememberColor3-VLA-v0'\nbegun = threading.Semaphore(0)\n"
        "def work():\n    begun.release()\n"
        + textwrap.indent(textwrap.dedent(work), "    ")
        + "\nfor _ in range(2):\n    threading.Thread(target=work, daemon=True).start()\n"
        "begun.acquire()\nbegun.acquire()\n" + textwrap.dedent(rest)
    )


@pytest.mark.parametrize("work", AT_WORK)
@pytest.mark.parametrize("seconds", [0.02, 0.3])
def test_the_interpreter_ends_while_daemon_threads_work(work, seconds):
    result = run(with_threads(AT_WORK[work], f"time.sleep({seconds})\nprint('end')"))
    assert (result.returncode, result.stdout, result.stderr) == (0, "end\n", "")


def test_the_import_leaves_the_global_lock_as_it_was():
    asked = 'getattr(sys, "_is_gil_enabled", lambda: True)()'  # False in free-threaded Python
    done = run(f"import sys\nbefore = {asked}\nimport engram\nassert {asked} is before")
    assert done.returncode == 0, done.stderr


def test_a_policy_that_never_answers_does_not_keep_the_interpreter():
    work = """
        engram.evaluate(lambda observation: time.sleep(10_000), TASK, obs="state", threads=1)
    """
    result = run(with_threads(work, "time.sleep(0.3)"))
    assert (result.returncode, result.stderr) == (0, "")


def test_sys_exit_keeps_its_code():
    assert run(with_threads(AT_WORK["step"], "sys.exit(7)")).returncode == 7


def test_a_child_forked_while_threads_make_batches_can_make_batches():
    rest = """
        for attempt in range(20):
            time.sleep(0.05 + 0.013 * attempt % 0.1)
            child = os.fork()
            if child == 0:
                env = engram.make_vec(TASK, 2, obs_mode="rgb", threads=2)
                env.reset()
                env.step(env.act("random"))
                os._exit(0)
            for _ in range(600):
                done, status = os.waitpid(child, os.WNOHANG)
                if done:
                    break
                time.sleep(0.05)
            if not done or status:
                os.kill(child, 9)
                os.waitpid(child, 0)
                os._exit(1)
        os._exit(0)
    """
    work = """
        while True:
            env = engram.make_vec(TASK, 2, obs_mode="rgb", threads=2)
            env.reset()
            env.close()
    """
    assert run(with_threads(work, rest)).returncode == 0


def test_two_threads_on_one_batch(make):
    env = make(num_envs=16)
    env.reset(seed=0)
    actions = np.zeros((16, 7), np.float32)
    refused, stepped, unexpected = [], [], []

    def work():
        for _ in range(60):
            try:
                env.step(actions)
                stepped.append(1)
            except engram.BadStateError:
                refused.append(1)
            except BaseException as error:
                unexpected.append(error)

    threads = [threading.Thread(target=work) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not unexpected
    assert len(stepped) + len(refused) == 180
    assert stepped
    env.step(actions)


def test_closing_while_another_thread_steps(make):
    for _ in range(5):
        env = make(num_envs=32)
        env.reset(seed=0)
        actions = np.zeros((32, 7), np.float32)
        unexpected = []

        def work(env=env, actions=actions, unexpected=unexpected):
            try:
                while True:
                    env.step(actions)
            except engram.BadStateError:
                pass
            except BaseException as error:
                unexpected.append(error)

        thread = threading.Thread(target=work)
        thread.start()
        while env._views["elapsed_steps"].max() < 2:
            pass
        env.close()
        thread.join()
        assert not unexpected


def test_the_gil_is_free_while_a_step_runs(make):
    env = make(num_envs=4096, threads=1)
    env.reset(seed=0)
    actions = np.zeros((4096, 7), np.float32)
    counted, done = [0], threading.Event()

    def count():
        while not done.is_set():
            counted[0] += 1

    thread = threading.Thread(target=count)
    thread.start()
    before = counted[0]
    for _ in range(200):
        env.step(actions)
        if counted[0] - before > 100:
            break  # on a busy machine not within the first steps
    done.set()
    thread.join()
    assert counted[0] - before > 100


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_forked_process_gets_an_error_and_can_make_batches(make):
    env = make()
    obs, _ = env.reset(seed=0)
    expected = obs.copy()
    child = os.fork()
    if child == 0:
        status = 1
        try:
            try:
                env.step(ACTIONS)
            except engram.BadStateError as error:
                named = "fork" in str(error)
            env.close()
            own = engram.make_vec(TASK, 4, threads=2)
            same = np.array_equal(own.reset(seed=0)[0], expected)
            own.step(ACTIONS)
            own.close()
            del env, obs
            status = 0 if named and same else 2
        finally:
            os._exit(status)
    _, status = os.waitpid(child, 0)
    assert os.waitstatus_to_exitcode(status) == 0
    env.step(ACTIONS)
