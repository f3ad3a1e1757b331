"""Policies that name answers: engram.evaluate(choices=...), and the example over pipes."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import engram

TASK = "RememberColor3-VLA-v0"
EXAMPLE = Path(__file__).parents[1] / "examples" / "choices_policy.py"


def cue(question):
    """The object of the first frame, by the words of objects."""
    seen = re.search(r"(\w+ cube) at", question["text"][0])[1]
    return f"the {seen}"


def evaluate(choices, **options):
    options = {"ids": TASK, "episodes": 6, "obs": "objects", **options}
    return engram.evaluate(choices=choices, **options)["tasks"][0]


def test_a_memory_of_words_is_always_right():
    task = evaluate(cue)
    assert task["sr"] == 1.0
    assert task["first_answer_correct"] == 1.0
    assert task["choices"] is True
    assert task["memory_score"] is None


@pytest.mark.parametrize("wrap", [lambda i: i, lambda i: [i], np.int64, lambda i: (str(i),)])
def test_an_answer_is_a_text_an_index_or_a_list(wrap):
    def choose(question):
        return wrap(question["choices"].index(cue(question)))

    assert evaluate(choose) == evaluate(cue)


def test_a_question_has_frames_of_every_step_that_differs():
    seen = []

    def choose(question):
        frames = len(question["steps"])
        assert question["rgb"].shape == (frames, 128, 128, 6)
        assert question["rgb"].dtype == np.uint8
        assert question["proprio"].shape == (frames, 7)
        assert question["state"] is None
        assert question["text"] is None
        assert question["steps"][0] == 0
        assert question["steps"][-1] == question["step"]
        assert np.all(np.diff(question["steps"]) > 0)
        middle = question["rgb"][:-1]
        assert all((a != b).any() for a, b in zip(middle, middle[1:], strict=False))
        assert question["index"] == 0
        assert (question["least"], question["most"], question["repeats"]) == (1, 1, False)
        assert sorted(question["choices"]) == ["the blue cube", "the green cube", "the red cube"]
        assert question["instruction"] == engram.describe(TASK)["instruction"]
        seen.append(question["episode"])
        return 0

    evaluate(choose, obs="rgb", episodes=3)
    assert len(set(seen)) == 3


def test_tell_episodes_and_policy_seed_are_in_questions():
    def choose(question):
        assert question["seed"] == 4242424242 + question["episode"]
        assert question["policy_seed"] == 5
        return 0

    assert evaluate(choose, tell_episodes=True, policy_seed=5, episodes=2)["tell_episodes"] is True


def test_the_stride_is_part_of_the_results():
    def choose(question):
        assert all(step % 5 == 0 for step in question["steps"][:-1])
        return 0

    assert evaluate(choose, choices_stride=5)["choices_stride"] == 5


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        ("the pink cube", "choice 'the pink cube' given, the "),
        (3, "choice 3 given, 0 to 2 allowed"),
        (-1, "choice '-1' given"),
        ([0, 1], "2 choices given, 1 needed"),
        ([], "0 choices given, 1 needed"),
        (None, "choices: None given, a text, an index or a list of them needed"),
        (1.0, "choices: 1.0 given"),
        (True, "choices: True given"),
    ],
)
def test_other_answers_are_refused(answer, words):
    with pytest.raises(engram.Error, match=re.escape(words)):
        evaluate(lambda _: answer)


def test_errors_of_the_function_are_raised():
    with pytest.raises(ZeroDivisionError):
        evaluate(lambda _: 1 // 0)


def test_arguments_are_checked():
    with pytest.raises(engram.InvalidArgumentError, match="policy, choices: one of them"):
        engram.evaluate(lambda _: 0, TASK, choices=lambda _: 0)
    with pytest.raises(engram.InvalidArgumentError, match="choices: 3 given, a function needed"):
        engram.evaluate(choices=3, ids=TASK)
    with pytest.raises(engram.InvalidArgumentError, match="policy: None given"):
        engram.evaluate(ids=TASK)
    with pytest.raises(engram.InvalidArgumentError, match="choices_stride: 0 given, 1 to"):
        evaluate(cue, choices_stride=0)
    with pytest.raises(engram.InvalidArgumentError, match="has no list of answers"):
        evaluate(cue, ids="InterceptSlow-VLA-v0")


def test_a_description_has_the_choices():
    choices = engram.describe("SeqOfColors3-VLA-v0")["choices"]
    assert choices["least"] == choices["most"] == 3
    assert "the red cube" in choices["choices"]
    assert engram.describe("RotateLenientPos-VLA-v0")["choices"] is None


def test_the_example_over_pipes_is_right_without_pictures():
    command = f"{sys.executable} {EXAMPLE}"
    words = ["eval", TASK, "TakeItBack-VLA-v0", "--episodes", "4", "--obs", "objects", "--json"]
    done = subprocess.run(
        [sys.executable, "-m", "engram", *words, "--policy-choices", command],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert [task["sr"] for task in json.loads(done.stdout)["tasks"]] == [1.0, 1.0]


def play_asked(env, seed, right):
    """An episode in which the first environment is asked; returns its last info."""
    env.reset(seed=[seed] * env.num_envs)
    cue = env.words()[0]["memory"].replace("the cue was a ", "the ")
    env.ask()
    asked = 0
    for _ in range(env.description["horizon"]):
        question = env.question()
        if question["due"]:
            asked += 1
            index = question["choices"].index(cue)
            env.answer([index if right else (index + 1) % 3])
        _, _, _, _, info = env.step(env.act("blind"))
    assert asked == 1
    return info


def test_an_answer_is_named_while_an_episode_runs(make):
    env = make(TASK, 2, autoreset_mode="DISABLED")
    for seed in range(4):
        right = play_asked(env, seed, True)
        wrong = play_asked(env, seed, False)
        assert right["success_once"][0]
        assert not wrong["success_once"][0]
        # The other environment guesses as ever.
        assert right["first_answer_correct"][1] == wrong["first_answer_correct"][1]


def test_questions_that_are_not_due_are_refused(make):
    env = make(TASK, 1)
    with pytest.raises(engram.BadStateError):
        env.ask()
    env.reset(seed=1)
    with pytest.raises(engram.BadStateError, match="no question is due"):
        env.answer([0])
    with pytest.raises(engram.Error, match="0 to 0 allowed"):
        env.ask(1)
    with pytest.raises(engram.Error, match="choices"):
        env.answer(["the red cube"])
    none = make("InterceptMedium-VLA-v0", 1)
    none.reset(seed=1)
    with pytest.raises(engram.Error, match="has no list of answers"):
        none.ask()


def test_questions_list_answers_as_evaluations_do(make):
    env = make(TASK, 1)
    listed = []
    engram.evaluate(
        choices=lambda question: listed.append(question["choices"]) or 0,
        ids=TASK, episodes=5, seed=3, threads=1, num_envs=1, obs="objects",
    )  # fmt: skip
    for i, choices in enumerate(listed):
        env.reset(seed=3 + i)
        env.ask()
        assert env.question()["choices"] == choices
