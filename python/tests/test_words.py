"""Episodes in words."""

from __future__ import annotations

import pytest

import engram


def test_words_of_a_batch_follow_its_episodes() -> None:
    env = engram.make_vec("RememberColor3-VLA-v0", num_envs=2, pins={"cue_steps": 2})
    env.reset(seed=1)
    for _ in range(2):
        assert [words["subtask"] for words in env.words()] == [0, 0]
        env.step(env.act("zero"))
    for words in env.words():
        assert set(words) == {
            "plan",
            "subtask",
            "subtasks_done",
            "memory",
            "object",
            "paraphrases",
        }
        assert words["subtask"] == words["subtasks_done"] == 1
        assert words["plan"][:2] == ["remember the color of the cube", "wait"]
        assert words["object"] is None
        color = words["memory"].removeprefix("the cue was a ")
        assert words["plan"][3] == f"touch the {color}"
        assert len(words["paraphrases"]) >= 10


def test_words_have_the_numbers_of_the_episode() -> None:
    env = engram.make("RotateLenientPos-VLA-v0")
    env.reset(seed=3)
    number = next(word for word in env.unwrapped.language_instruction.split() if word.isdigit())
    words = env.unwrapped.words()
    assert words["plan"][1] == f"rotate the peg by {number} degrees"
    assert all(number in text for text in words["paraphrases"])
    assert all("{angle_deg}" in text for text in engram.describe(env.spec.id)["paraphrases"])


def test_words_need_an_episode() -> None:
    with pytest.raises(engram.BadStateError):
        engram.make_vec("RememberColor3-VLA-v0", num_envs=1).words()


def test_words_of_several_tasks() -> None:
    env = engram.make_vec(["RememberColor3-VLA-v0", "InterceptSlow-VLA-v0"], num_envs=4)
    env.reset(seed=0)
    assert [words["object"] for words in env.words()][2:] == ["ball", "ball"]
    assert env.words()[3]["memory"] == ""
