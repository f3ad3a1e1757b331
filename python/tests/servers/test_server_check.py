"""Checks of a server before a run: policies with known mistakes in a released server."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from policy_servers import TASK, engram_serve, in_thread, openpi_server, run_engram

import engram
from engram.servers import check
from engram.servers.checking.command import check_server
from engram.servers.checking.inputs import jumps_of
from engram.servers.checking.recording import record, states_of
from engram.servers.conventions import from_engram

SEED = 4242424242
TURNS = "ShellGamePick-VLA-v0"  # 24 steps, in which the oracle moves, turns and grasps
Say = Callable[[np.ndarray, dict[str, Any]], np.ndarray]


class Oracle:
    """A policy of openpi's kind with the oracle's actions, which it sends in a way of its own."""

    def __init__(self, id: str, say: Say, spacing: int = 1, keeps: bool | None = None) -> None:
        self.recording = record(id, SEED)
        self.say, self.spacing, self.keeps = say, spacing, keeps
        self.seen = 0.0  # of frames

    def infer(self, obs: dict[str, Any]) -> dict[str, Any]:
        actions = self.recording.actions
        step = int(obs["engram"]["step"])
        rows = np.minimum(step + self.spacing * np.arange(5), len(actions) - 1)
        if step == 0 and self.keeps is False:
            self.seen = 0.0
        self.seen += float(obs["observation/image"].mean())
        memory = 0.0001 * self.seen * (self.keeps is not None)
        return {"actions": self.say(actions[rows], obs) + memory}

    def reset(self) -> None:
        pass


@contextlib.contextmanager
def served(policy: Any) -> Iterator[str]:
    """The policy in the server that openpi released."""
    server_class = pytest.importorskip("openpi_server").WebsocketPolicyServer

    async def run(ready: Callable[[int], None]) -> None:
        from websockets.asyncio.server import serve

        server = server_class(policy, host="127.0.0.1", port=0, metadata={})
        async with serve(server._handler, "127.0.0.1", 0, compression=None, max_size=None) as bound:
            ready(next(iter(bound.sockets)).getsockname()[1])
            await bound.serve_forever()

    with in_thread(run) as port:
        yield f"openpi://127.0.0.1:{port}"


def negated(actions: np.ndarray, first: int, last: int) -> np.ndarray:
    changed = actions.copy()
    changed[:, first:last] *= -1
    return changed


def plain(actions: np.ndarray, obs: dict[str, Any]) -> np.ndarray:
    return actions


def mistakes_of(report: dict[str, Any]) -> list[str]:
    return [f"{one['what']}: {one['likely']}" for one in report["findings"] if one["mistake"]]


def test_a_right_server_has_no_mistake():
    with served(Oracle(TURNS, plain)) as url:
        report = check(url, TURNS, tell_episodes=True)
    assert mistakes_of(report) == []
    assert report["chunk"] == 5
    assert report["agreement"] == pytest.approx(1)
    for number in report["numbers"]:
        if number["like"] is not None:
            assert number["like"] == number["name"]
            assert number["scale"] == pytest.approx(1, abs=1e-4)
    assert not report["random"]
    assert not report["remembers"]
    assert set(report["influence"]) == {"instruction", "base image", "wrist image", "state"}


@pytest.mark.parametrize(
    ("say", "words"),
    [
        (lambda a, _: negated(a, 6, 7), "gripper with open and closed exchanged"),
        (lambda a, _: negated(a, 3, 6), "rotation with the opposite sign"),
        (lambda a, _: a[:, [0, 1, 2, 5, 4, 3, 6]], "rotation in the order yaw, pitch, roll"),
        (lambda a, _: a[:, [1, 0, 2, 3, 4, 5, 6]], "translation in the order y, x, z"),
        (lambda a, _: from_engram("libero", a), "the server sends actions of libero"),
        (lambda a, _: a * [9, 9, 9, 9, 9, 9, 1], "unnormalised"),
        (lambda a, _: a * [0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 1], "oxe|normalised"),
    ],
)
def test_mistakes_in_actions_are_named(say, words):
    with served(Oracle(TURNS, say)) as url:
        found = mistakes_of(check(url, TURNS, tell_episodes=True))
    assert any(word in one for one in found for word in words.split("|")), found


def test_a_chunk_of_another_rate_is_named():
    with served(Oracle(TURNS, plain, spacing=2)) as url:
        found = mistakes_of(check(url, TURNS, tell_episodes=True))
    assert len(found) == 1
    assert "2 steps apart" in found[0]
    assert "acts 10 times a second; the robot acts 20 times" in found[0]


@pytest.mark.parametrize("layout", ["tcp7_continuous", "libero_rpy8", "libero8"])
def test_the_form_of_the_state_that_a_policy_was_trained_on_is_named(layout):
    """A policy whose answers are right for one form of the state."""
    recording = record(TURNS, SEED)
    right = states_of(layout, recording.proprio)

    def say(actions: np.ndarray, obs: dict[str, Any]) -> np.ndarray:
        error = obs["observation/state"] - right[int(obs["engram"]["step"])]
        return actions + 0.2 * np.abs(error).max()

    keys = {"tcp7_continuous": "mikasa"}.get(layout, "libero")
    given = {"libero8": "libero_rpy8", "libero_rpy8": "libero8"}.get(layout, "tcp7")
    options = {"keys": keys, "actions": "mikasa"}
    with served(Oracle(TURNS, say)) as url:
        wrong = check(url, TURNS, tell_episodes=True, state=given, **options)
        assert mistakes_of(check(url, TURNS, tell_episodes=True, state=layout, **options)) == []
    remedies = [one["remedy"] for one in wrong["findings"] if one["mistake"]]
    assert f"--server-state {layout}" in remedies


def test_a_memory_that_outlasts_its_episode_is_named():
    """And one that ends with it is none."""
    with served(Oracle(TASK, plain, keeps=True)) as url:
        leaking = mistakes_of(check(url, tell_episodes=True))
    with served(Oracle(TASK, plain, keeps=False)) as url:
        report = check(url, tell_episodes=True)
    assert any("does not forget the one before" in one for one in leaking)
    assert report["remembers"]
    assert mistakes_of(report) == []


def test_a_server_that_wants_other_keys_is_asked_in_their_ways():
    def act(obs: dict[str, Any]) -> np.ndarray:
        if obs["observation/state"].shape != (8,):
            raise ValueError("state of 8 numbers needed")
        return np.zeros((3, 7))

    class Policy:
        infer = staticmethod(lambda obs: {"actions": act(obs)})
        reset = staticmethod(lambda: None)

    with served(Policy()) as url:
        report = check(url)
        assert check(url, keys="libero")["chunk"] == 3
    (finding,) = report["findings"]
    assert "reports: ValueError: state of 8 numbers" in finding["what"] or (
        "state of 8 numbers needed" in finding["what"]
    )
    assert "--server-keys libero" in finding["likely"]
    assert "--server-state libero8" in finding["likely"]


def test_eight_numbers_are_of_joints():
    with openpi_server(lambda obs: np.zeros((3, 8))) as url:
        (finding,) = check(url)["findings"]
    assert finding["remedy"] == "--control-mode pd_joint_pos"


def test_states_of_policies_that_know_no_gap_do_not_jump():
    proprio = record(TURNS, SEED).proprio
    assert jumps_of("tcp7", proprio) > 0
    for layout in ("tcp7_continuous", "libero8", "libero_rpy8", "oxe8"):
        assert jumps_of(layout, proprio) == 0, layout


def test_small_motions_say_what_each_number_does():
    with openpi_server(lambda obs: np.zeros((3, 7))) as url:
        first, *_, yaw, gripper = check(url)["motions"]
        libero = check(url, actions="libero")["motions"]
    assert first.startswith("0 delta_x: +0.5 moves x by +")
    assert "moves yaw by -0." in yaw
    assert gripper.startswith("6 gripper: -1 moves opening by -")
    assert libero[0].startswith("0 delta_x: +1 moves x by +")
    assert "moves yaw by +0." in libero[5]
    assert libero[6].startswith("6 gripper: +1 moves opening by -")


def test_the_command(capsys):
    def run(*words: str) -> tuple[int, str]:
        code = check_server(list(words))
        printed = capsys.readouterr()
        return code, printed.out + printed.err

    with engram_serve("--policy", "oracle", "--chunk", "4") as url:
        good = run_engram("servers", "check", url, "--tell-episodes")
        code, document = run(url, TASK, "--tell-episodes", "--json")
        untold = run(url)
    assert good.returncode == 0, good.stdout + good.stderr
    assert good.stdout.splitlines()[-1] == "no likely mistake"
    assert code == 0
    assert json.loads(document)["chunk"] == 4
    assert untold[0] == 1
    assert "oracle needs env_id, seed and step" in untold[1]
    for words, message in (
        (("openpi://127.0.0.1:1", "Remember"), "no task 'Remember'"),
        (("http://x",), "HOST:PORT needed"),
        (("openpi://x?speed=1",), "option 'speed' given"),
    ):
        code, text = run(*words)
        assert code == 2, text
        assert message in text


def test_ids_are_needed():
    with pytest.raises(engram.InvalidArgumentError, match="one id or several needed"):
        check("openpi://127.0.0.1:1", [])
