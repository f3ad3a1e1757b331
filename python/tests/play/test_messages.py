"""Validation of the page's messages."""

from __future__ import annotations

import json
import random

import pytest

from engram.play.messages import MessageError, parse

GOOD = [
    {"do": "play", "id": "RememberColor3-VLA-v0", "seed": "7", "pins": {"target": 2}},
    {"do": "play", "id": "x", "seed": None, "constants": {"CUE_PHASE_STEPS": [3, 5], "A": "b"}},
    {"do": "play", "id": "x", "seed": None, "choices": True},
    {"do": "choose", "choices": [2, 0]},
    {"do": "act", "a": [0, 0.5, -1, 0, 0, 0, 1], "n": 3, "held": True},
    {"do": "step", "a": [0] * 7, "n": 0},
    {"do": "run", "on": False},
    {"do": "speed", "of": 0.25, "turns": False},
    {"do": "seen", "n": 5},
    {"do": "watch", "id": "x", "source": "oracle"},
    {"do": "stored", "folder": 0, "task": 0, "episode": 1},
    {"do": "frame", "n": 3},
    {"do": "grid", "id": "x", "source": "sweep", "seed": "1"},
    {"do": "save"},
    {"do": "stop"},
]
BAD = [
    "",
    "{",
    "[]",
    "3",
    '{"do": 1}',
    '{"do": "close"}',
    '{"do": "save", "file": "/etc/passwd"}',
    '{"do": "run"}',
    '{"do": "run", "on": 1}',
    '{"do": "seen", "n": true}',
    '{"do": "seen", "n": -1}',
    '{"do": "seen", "n": 1e3}',
    '{"do": "act", "a": [0,0,0,0,0,0], "n": 1, "held": true}',
    '{"do": "act", "a": [0,0,0,0,0,0,1.5], "n": 1, "held": true}',
    '{"do": "act", "a": [0,0,0,0,0,0,NaN], "n": 1, "held": true}',
    '{"do": "act", "a": [0,0,0,0,0,0,1e999], "n": 1, "held": true}',
    '{"do": "play", "id": "x", "seed": 7}',
    '{"do": "play", "id": "x", "seed": "9223372036854775808"}',
    '{"do": "play", "id": "x", "seed": "\u0663"}',
    '{"do": "play", "id": "", "seed": null}',
    '{"do": "play", "id": "x", "seed": null, "choices": 1}',
    '{"do": "watch", "id": "x", "source": "oracle", "choices": true}',
    '{"do": "choose"}',
    '{"do": "choose", "choices": []}',
    '{"do": "choose", "choices": [-1]}',
    '{"do": "choose", "choices": ["the red cube"]}',
    '{"do": "choose", "choices": [true]}',
    '{"do": "play", "id": ["x"]}',
    '{"do": "play", "id": "x", "pins": {"a": {"b": 1}}}',
    '{"do": "play", "id": "x", "pins": {"a": [[1]]}}',
    '{"do": "play", "id": "x", "pins": {"a": null}}',
    '{"do": "watch", "id": "x", "source": "rm -rf /; this is long"}',
    "[" * 5000,
    '{"do": "seen", "n": ' + "9" * 5000 + "}",
]


@pytest.mark.parametrize("message", GOOD, ids=lambda message: message["do"])
def test_messages_of_the_page_are_accepted(message):
    assert parse(json.dumps(message)) == message


@pytest.mark.parametrize("text", BAD, ids=lambda text: text[:40])
def test_anything_else_is_refused_in_a_short_sentence(text):
    with pytest.raises(MessageError) as error:
        parse(text)
    assert len(str(error.value)) < 300


def mutated(rng: random.Random) -> str:
    """A good message with something wrong in it; it may still be good."""
    message = json.loads(json.dumps(rng.choice(GOOD)))
    for _ in range(rng.randint(0, 3)):
        key = rng.choice([*message, "extra"])
        message[key] = rng.choice(
            [None, True, -1, 2**70, 1e308, "", "x" * 200, "../..", [], [1] * 100, {}, {"a": [{}]}]
        )
    text = json.dumps(message)
    for _ in range(rng.randint(0, 4)):
        at = rng.randrange(len(text) + 1)
        piece = rng.choice(["", '"', "{", "\\u0000", "\\ud800", "NaN", "\x00", "é", "]" * 9])
        text = text[:at] + piece + text[at + rng.randint(0, 3) :]
    return text


def test_random_messages_are_accepted_or_refused():
    rng = random.Random(7)
    accepted = 0
    for _ in range(10_000):
        try:
            parse(mutated(rng))
            accepted += 1
        except MessageError:
            pass
    assert 0 < accepted < 9_000
