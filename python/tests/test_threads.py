"""Threads that still work when the interpreter ends, and processes that are forked meanwhile."""

from __future__ import annotations

import subprocess
import sys
import textwrap

import pytest

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
