"""OpenEnv as released: its own client plays episodes of a server."""

from __future__ import annotations

import socket
import subprocess
import sys
import time
from contextlib import contextmanager
from dataclasses import replace

import pytest

pytest.importorskip("openenv")

from doc_blocks import groups
from openenv.core import GenericEnvClient

import engram

SEEDS = range(4242424242, 4242424246)


@contextmanager
def served(task):
    """The address of a server of the task."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    words = [sys.executable, "-m", "engram.integrations.openenv", task, "--port", str(port)]
    with subprocess.Popen(words) as server:
        for _ in range(300):
            with socket.socket() as probe:
                if probe.connect_ex(("127.0.0.1", port)) == 0:
                    break
            time.sleep(0.1)
        yield f"http://127.0.0.1:{port}"
        server.terminate()


def expected(task, choose):
    """Questions and outcomes of the same episodes in engram's evaluation."""
    asked = []

    def answer(question):
        asked.append(question)
        return choose(question)

    result = engram.evaluate(
        choices=answer, ids=task, episodes=len(SEEDS), seed=SEEDS[0], obs="objects", threads=1
    )
    return asked, result["tasks"][0]


@pytest.mark.parametrize("task", ["ShellGameTouch-VLA-v0", "SeqOfColors3-VLA-v0"])
def test_episodes_are_those_of_an_evaluation(task):
    def choose(question):
        return question["choices"][: question["most"]]

    asked, result = expected(task, choose)
    by_question = {tuple(one["text"]): one for one in asked}
    with served(task) as url, GenericEnvClient(base_url=url).sync() as env:
        for i, seed in enumerate(SEEDS):
            seen = env.reset(seed=seed)
            assert not seen.done
            question = seen.observation
            texts = [frame.split(": ", 1)[1] for frame in question["frames"]]
            same = by_question[tuple(texts)]
            for key in ("question", "choices", "least", "most", "repeats", "instruction"):
                assert question[key] == same[key]
            end = env.step({"answer": choose(question)})
            assert end.done
            assert end.reward == float(result["successes"][i])


def test_what_is_no_answer_changes_nothing_and_sessions_are_apart():
    task = "ShellGameTouch-VLA-v0"
    with served(task) as url:
        clients = [GenericEnvClient(base_url=url).sync() for _ in range(3)]
        questions = [one.reset(seed=seed).observation for one, seed in zip(clients, SEEDS)]
        with pytest.raises(Exception, match=r"1 to 1 of .* needed, each once"):
            clients[0].step({"answer": ["the glass"]})
        with pytest.raises(Exception, match="1 to 1 of"):
            clients[0].step({"answer": questions[0]["choices"][:2]})
        rewards = []
        for one, question in zip(clients, questions):
            end = one.step({"answer": question["choices"][:1]})
            assert end.done
            rewards.append(end.reward)
        _, result = expected(task, lambda question: 0)
        assert rewards == [float(success) for success in result["successes"][:3]]
        with pytest.raises(Exception, match="no question is due"):
            clients[0].step({"answer": questions[0]["choices"][:1]})
        # An episode that is left begins anew.
        clients[1].reset(seed=SEEDS[1])
        assert clients[1].reset(seed=SEEDS[1]).observation == questions[1]
        for one in clients:
            one.close()


def test_the_block_of_the_page(tmp_path):
    (block,) = [b for group in groups() for b in group if b.elsewhere == "openenv"]
    with served("ShellGameTouch-VLA-v0") as url:
        moved = replace(block, text=block.text.replace("http://127.0.0.1:8000", url))
        assert "Which cup is meant?" in moved.run(tmp_path)


def test_a_task_without_choices_is_refused():
    words = [sys.executable, "-m", "engram.integrations.openenv", "InterceptSlow-VLA-v0"]
    run = subprocess.run(words, capture_output=True, text=True, timeout=60, check=False)
    assert run.returncode != 0
    assert "a task with choices needed" in run.stderr
