"""Probes of memory with policies in Python."""

import json

import numpy as np
import pytest

import engram

ID = "ShellGameTouch-VLA-v0"
TCP = slice(18, 21)
BALL, CUP = 34, 35  # kinds of a token


def places(row, kind):
    """Intervals of things of that kind, from one side to the other."""
    tokens = row[25:].reshape(4, 42)
    return sorted((token[1:3] for token in tokens if token[kind]), key=lambda place: place[1])


class Remembering:
    """Touches the cup under which it has last seen the ball, in each slot since `first`."""

    def __init__(self):
        self.cups = {}
        self.requests = []

    def __call__(self, observation):
        actions = np.zeros((len(observation["slot"]), 7), np.float32)
        for i, row in enumerate(observation["state"]):
            key = observation["worker"], int(observation["slot"][i])
            if observation["first"][i]:
                self.cups.pop(key, None)
            self.requests.append((int(observation["step"][i]), bool(observation["first"][i])))
            cups = places(row, CUP)
            for ball in places(row, BALL):
                self.cups[key] = int(np.searchsorted((-0.2, 0.2), ball[1]))
            if cups:
                goal = np.append(cups[self.cups.get(key, 1)], 0.16)
                actions[i, :3] = np.clip(14 * (goal - row[TCP]), -1, 1)
        return actions


def probe(policy, *probes, **options):
    document = engram.probe(
        policy, ID, obs="objects", probes=probes, **{"episodes": 4, "threads": 1, **options}
    )
    return document["tasks"][0]


def test_a_callable_follows_its_past():
    policy = Remembering()
    twins = probe(policy, "twins")["twins"]
    assert twins["follow"]["rate"] == 1
    assert twins["swapped"]["past"]["rate"] == 1
    assert twins["swapped"]["scene"]["rate"] == 0
    assert twins["presents"]["equal"] == twins["presents"]["compared"] == 20
    # A wiped policy is told so at the question, with the step that it is at.
    assert any(first and step > 0 for step, first in policy.requests)


def test_nobody_is_told_of_the_episodes_between():
    policy = Remembering()
    points = probe(policy, "interference")["interference"]["points"]
    rates = {(one["kind"], one["others"]): one["first_answer"]["rate"] for one in points}
    assert rates == {
        ("none", 0): 1,
        **{("competing", count): 0 for count in (1, 3, 7)},
        **{("agreeing", count): 1 for count in (1, 3, 7)},
    }
    firsts = sum(first for _, first in policy.requests)
    assert firsts == 4 * len(points)


def test_results_are_the_same_for_any_threads_and_batch_size(tmp_path):
    documents = [
        engram.probe(
            Remembering(), ID, obs="objects", episodes=3, threads=threads, num_envs=num_envs
        )
        for threads, num_envs in ((1, 1), (2, 8))
    ]
    assert documents[0] == documents[1]


def test_files_are_written(tmp_path):
    document = engram.probe(
        Remembering(), ID, obs="objects", probes=["twins"], episodes=1, output=tmp_path
    )
    assert json.loads((tmp_path / "probe.json").read_text()) == document
    assert "<h2>Twins</h2>" in (tmp_path / "probe.html").read_text()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"probes": ["twin"]}, "'twin' given"),
        ({"probes": []}, "given"),
        ({"probes": "twins"}, "a list of words needed"),
        ({"other": "Nothing-v0"}, "Nothing-v0"),
        ({"obs": "depth"}, "'rgb', 'state' or 'objects' allowed"),
    ],
)
def test_wrong_arguments_are_refused(options, message):
    with pytest.raises(engram.Error, match=message):
        engram.probe(Remembering(), ID, **{"obs": "objects", "episodes": 1, **options})


def test_an_exception_of_the_policy_comes_out():
    def fails(observation):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        probe(fails, "twins")
