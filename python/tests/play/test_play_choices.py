"""Episodes in which the player names answers, over a WebSocket without a browser."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from play_server import SECONDS, Page, Server

import engram
from engram.play.episode_spec import EpisodeSpec

TASK = "RememberColor3-VLA-v0"


def asked(page: Page, id: str, seed: int) -> dict[str, Any]:
    """Plays an episode in which answers are named, to its first question."""
    page.play(id, seed, choices=True)
    page.send("run", on=True)
    return page.receive("question")


def cue_of(id: str, seed: int) -> str:
    """The answer that is right, as the question names it."""
    mirror = EpisodeSpec(id, seed).make_batch()
    mirror.reset(seed=seed)
    cue: str = mirror.words()[0]["memory"].replace("the cue was a ", "the ")
    mirror.close()
    return cue


def test_the_hand_carries_out_the_answer_that_is_named(server: Server):
    with server.page() as page:
        for seed, right in ((31, True), (32, False)):
            question = asked(page, TASK, seed)
            assert question["question"] == "Which object is to be touched?"
            assert sorted(question["choices"]) == [
                "the blue cube", "the green cube", "the red cube",
            ]  # fmt: skip
            cue = question["choices"].index(cue_of(TASK, seed))
            page.send("choose", choices=[cue if right else (cue + 1) % 3])
            ended = page.receive("ended")
            assert ended["success"] == ended["first_answer_correct"] == right
            assert ended["counted"]
            assert ended["savable"] == right
        score = ended["score"]
        described = engram.describe(TASK)
        assert (score["successes"], score["episodes"]) == (1, 2)
        assert score["chance"] == described["choices"]["chance"]
        assert score["sweep"] is None
        # Episodes of the player's own hands have a score of their own.
        assert page.play(TASK)["score"]["episodes"] != 2


def test_time_stands_still_until_the_answer(server: Server):
    mirror = EpisodeSpec(TASK, 33).make_batch()
    mirror.reset(seed=33)
    mirror.ask()
    with server.page() as page:
        page.play(TASK, 33, choices=True)
        steps = 0
        while not mirror.question()["due"]:
            mirror.step(mirror.act("blind"))
            steps += 1
            # What the player sends is no action of the robot's.
            assert page.step([1, 1, 1, 0, 0, 0, 1])["n"] == steps
        page.receive("question")
        page.send("step", a=[0] * 7, n=0)
        with pytest.raises(AssertionError, match="choose first"):
            page.receive("nothing")
        page.send("choose", choices=[0, 1])
        with pytest.raises(AssertionError, match="2 choices given, 1 needed"):
            page.receive("nothing")
        page.send("choose", choices=[0])
        page.receive("chosen")
        assert page.step([0] * 7)["n"] == steps + 1
        page.send("choose", choices=[0])
        with pytest.raises(AssertionError, match="there is no question"):
            page.receive("nothing")
    mirror.close()


def test_questions_come_in_every_round(server: Server):
    id = "BatteriesCheckerEasy-6-VLA-v0"
    with server.page() as page:
        question = asked(page, id, 5)
        count = 0
        while True:
            count += 1
            page.send("choose", choices=[0])
            while True:
                kind = page.socket.recv(timeout=SECONDS)
                message = json.loads(kind) if isinstance(kind, str) else {}
                if message.get("type") in ("question", "ended"):
                    break
                assert message.get("type") != "error", message
            if message["type"] == "ended":
                break
            question = message
    assert 1 <= count <= engram.describe(id)["choices"]["questions"]
    assert question["choices"]


def test_choices_are_refused_where_a_task_has_none(server: Server):
    with server.page() as page:
        page.send("play", id="InterceptMedium-VLA-v0", seed="1", choices=True)
        with pytest.raises(AssertionError, match="has no list of answers"):
            page.receive("opened")


def test_an_episode_by_choices_is_replayed_from_its_file(server: Server):
    with server.page() as page:
        question = asked(page, TASK, 34)
        page.send("choose", choices=[question["choices"].index(cue_of(TASK, 34))])
        page.receive("ended")
        page.send("save")
        file = Path(page.receive("saved")["file"])
    with np.load(file) as data:
        assert data["success"][-1]
