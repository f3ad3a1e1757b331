"""Policies of the command line that hang, drip, die or shout: one deadline, one short sentence."""

from __future__ import annotations

import concurrent.futures
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from play_server import Server, serving

from engram.play.episode_spec import EpisodeSpec
from engram.play.policy_process import PolicyError, PolicyProcess
from engram.play.sources import Sources

TASK = "RememberColor3-VLA-v0"
PIPE_POLICY = Path(__file__).parents[2] / "examples" / "pipe_policy.py"
GREETING = r"printf '\1\0\0\0\10\0\0\0ENGM\1\0\0\0'"


def ask(command: str, timeout: float, obs: str = "rgb", num_envs: int = 4) -> str:
    """The failure of a policy's first answer."""
    env = EpisodeSpec(TASK, 3).make_batch(num_envs, obs_mode=obs)
    env.reset(seed=3)
    policy = PolicyProcess(command, obs, num_envs, timeout)
    try:
        with pytest.raises(PolicyError) as error:
            policy.act(env, True)
    finally:
        policy.close()
        env.close()
    return str(error.value)


@pytest.mark.parametrize(
    "command",
    [
        "sleep 100",
        f"{GREETING}; sleep 100",  # reads nothing: a request is larger than a pipe
        f"{GREETING}; while head -c 100 >/dev/null; do sleep 0.05; done; sleep 100",
        r"printf '\1\0\0\0\377\0\0\0'; while printf x; do sleep 0.05; done",
        f"{GREETING}; cat >/dev/null & " + r"sleep 0.1; printf '\4\0\0\0\377\0\0\0';"
        " while printf x; do sleep 0.05; done",
    ],
    ids=["silent", "reads nothing", "reads little", "drips", "drips an answer"],
)
def test_one_deadline_for_request_and_answer(command):
    start = time.monotonic()
    assert "did not answer within 1 s" in ask(command, 1)
    assert time.monotonic() - start < 10


def test_a_failure_is_cut_and_printable():
    start = time.monotonic()
    shout = r"printf '\5\0\0\0\0\302\353\13\233[31m\342\200\256\33]0;x\7'; yes 'no such file'"
    message = ask(shout, 60)
    assert time.monotonic() - start < 20
    assert message.isprintable()
    assert len(message) < 700
    assert message.startswith(
        "the policy reported a failure: \\x9b[31m\\u202e\\x1b]0;x\\x07no such"
    )


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("exit 3", "ended with exit code 3"),
        ("kill -9 $$", "ended by signal 9"),
        (f"{GREETING}; exit 0", "ended with exit code 0"),
        ("exec <&- >&-; sleep 100", "closed its standard input or output"),
    ],
)
def test_the_end_of_a_policy_is_reported(command, words):
    start = time.monotonic()
    assert words in ask(command, 50)
    assert time.monotonic() - start < 10


def test_two_threads_may_end_a_policy():
    """The engine's, as its answer is late, and the server's, as it is interrupted."""
    env = EpisodeSpec(TASK, 3).make_batch(1, obs_mode="state")
    env.reset(seed=3)
    sources = Sources([], "sleep 0.5", "state", 0.01, 1)
    act, _ = sources.policy("process")
    with concurrent.futures.ThreadPoolExecutor(1) as engine:
        answer = engine.submit(act, env, True)
        time.sleep(0.2)
        sources.close()
        with pytest.raises(PolicyError, match="did not answer"):
            answer.result()
    env.close()


def watch_what_hangs(page: Any) -> float:
    """Watches a policy that does not answer; the time after a second of that."""
    page.receive("hello")
    page.send("watch", id=TASK, source="process")
    time.sleep(1)
    return time.monotonic()


def test_an_answer_that_nobody_wants_is_not_waited_for(tmp_path):
    """A policy hangs for a minute; the page goes on at once, and so does another tab."""
    slow = f"{GREETING}; sleep 60"
    with serving(tmp_path / "out", "--policy-command", slow) as server, server.page() as page:
        start = watch_what_hangs(page)
        page.play(TASK, 3)
        assert time.monotonic() - start < 15
        page.send("grid", id=TASK, source="process", seed="1")
        page.receive("grid")
        page.send("run", on=True)
        page.receive("running")
        time.sleep(1)
        with server.page() as other:
            other.receive("busy")  # after the seconds in which a reloaded page's tab may close
            start = time.monotonic()
            other.send("take")
            other.receive("hello")
            assert time.monotonic() - start < 3
            other.play(TASK, 3)
        assert time.monotonic() - start < 15


def test_the_server_ends_although_a_policy_hangs(tmp_path):
    hangs = f"{GREETING}; sleep 60"
    with serving(tmp_path / "out", "--policy-command", hangs) as server, server.page() as page:
        start = watch_what_hangs(page)
        assert "Traceback" not in server.end()
        assert time.monotonic() - start < 15
        assert server.process.returncode == 130


def test_a_grid_reports_a_policy_that_dies_and_can_begin_again(tmp_path):
    once = tmp_path / "once"
    command = f"test -e {once} || {{ touch {once}; exit 4; }}; exec {sys.executable} {PIPE_POLICY}"
    with serving(tmp_path / "out", "--policy-command", command) as server:
        _grid_fails_once(server)


def _grid_fails_once(server: Server) -> None:
    with server.page() as page:
        page.send("grid", id=TASK, source="process", seed="1")
        page.receive("grid")
        page.send("run", on=True)
        with pytest.raises(AssertionError, match="exit code 4"):
            page.receive("nothing")
        page.send("grid", id=TASK, source="process", seed="1")
        page.send("run", on=True)
        while page.receive("grid").get("elapsed", 0) < 3:
            page.send("seen", n=0)
