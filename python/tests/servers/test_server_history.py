"""What servers see between two questions, and what a policy that remembers makes of it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from policy_servers import observation, openpi_server

import engram
from engram.servers import ServerPolicy

TASK = "SeqOfColors3-VLA-v0"  # three of nine colours, one after another, for 1 to 5 steps each
CHUNK = 16
STEP = 0.039  # m, of an action of 1 (docs/robot.md)
EPISODES = 20


def test_frames_of_a_question():
    """By their marks: last, all since the last question, three at a stride of two."""
    seen: list[list[int]] = []

    def act(request: dict[str, Any]) -> np.ndarray:
        pictures = request["observation/image"]
        assert request["observation/state"].shape[:-1] == pictures.shape[:-3]
        seen.append(np.atleast_1d(pictures[..., 0, 0, 0]).tolist())
        return np.zeros((4, 7))

    def play(policy: ServerPolicy, steps: int) -> None:
        for step in range(steps):
            made = observation(step=step)
            made["rgb"] = np.full((1, 128, 128, 6), step, np.uint8)
            policy(made)

    with openpi_server(act) as url:
        for history, expected in (
            ("since-last", [[0], [1, 2, 3, 4], [5, 6, 7, 8], [0], [1, 2, 3, 4]]),
            ("3,2", [[0, 0, 0], [0, 2, 4], [4, 6, 8], [0, 0, 0], [0, 2, 4]]),
        ):
            seen.clear()
            policy = ServerPolicy(url, history=history)
            play(policy, 9)
            play(policy, 5)
            assert seen == expected, history
            policy.close()
        seen.clear()
        policy = ServerPolicy(url)  # asked when a chunk is used up, by whoever uses it
        for step in (0, 4, 8):
            made = observation(step=step)
            made["rgb"] = np.full((1, 128, 128, 6), step, np.uint8)
            assert policy(made)[0].shape == (4, 7)
        assert seen == [[0], [4], [8]]
        policy.close()


class Layout:
    """Parts of a row of obs="objects"."""

    def __init__(self) -> None:
        env = engram.make_vec(TASK, 1, obs_mode="objects")
        fields = {f["name"]: f for f in env.description["state_fields"]}
        env.close()
        self.fields = fields
        self.objects = sum(name.endswith("_seen") for name in fields)

    def part(self, row: np.ndarray, name: str) -> np.ndarray:
        field = self.fields[name]
        start = field["offset"]
        return row[start : start + field["width"]]

    def cubes(self, row: np.ndarray) -> dict[int, np.ndarray]:
        """Positions (m) of the cubes in view, by colour."""
        found = {}
        for i in range(self.objects):
            kind = self.part(row, f"object_{i}_kind").argmax()
            names = self.fields[f"object_{i}_kind"]["names"]
            if self.part(row, f"object_{i}_seen")[0] == 1 and names[kind] == "object":
                color = int(self.part(row, f"object_{i}_color").argmax())
                found[color] = 0.5 * self.part(row, f"object_{i}_position")
        return found

    def button(self, row: np.ndarray) -> np.ndarray | None:
        for i in range(self.objects):
            names = self.fields[f"object_{i}_kind"]["names"]
            kind = names[self.part(row, f"object_{i}_kind").argmax()]
            if self.part(row, f"object_{i}_seen")[0] == 1 and kind == "button":
                return 0.5 * self.part(row, f"object_{i}_position")
        return None


class Rememberer:
    """Remembers the colours of the frames that it gets; touches them; presses the button.

    It answers with chunks of 16 and is asked when they are used up.
    """

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        self.begin()

    def begin(self) -> None:
        self.shown: list[int] = []
        self.goals: list[np.ndarray] = []
        self.planned = False

    def act(self, rows: np.ndarray, tcp: np.ndarray, first: bool) -> np.ndarray:
        if first:
            self.begin()
        for row in rows:
            cubes = self.layout.cubes(row)
            if len(cubes) == 1:  # of the cue
                self.shown += [color for color in cubes if color not in self.shown]
        cubes = self.layout.cubes(rows[-1])
        if len(cubes) == 9 and not self.planned:
            self.plan(cubes, self.layout.button(rows[-1]))
        return self.towards(tcp)

    def plan(self, cubes: dict[int, np.ndarray], button: Any) -> None:
        """Way points: above each cube, down to it, up; the same with the button."""
        self.planned = True
        for color in self.shown:
            over = cubes[color]
            self.goals += [[over[0], over[1], z] for z in (0.16, over[2] + 0.025, 0.16)]
        self.goals += [[button[0], button[1], z] for z in (0.17, 0.075, 0.19)]

    def towards(self, tcp: np.ndarray) -> np.ndarray:
        """The next way point in open loop: on the way, then at rest."""
        chunk = np.zeros((CHUNK, 7), np.float32)
        chunk[:, 6] = -1
        while self.goals and np.abs(np.subtract(self.goals[0], tcp)).max() < 0.012:
            self.goals.pop(0)
        if self.goals:
            moving = 10
            way = np.subtract(self.goals[0], tcp) / STEP / moving
            chunk[:moving, :3] = way / max(1, np.abs(way).max())
        return chunk


def success(layout: Layout, history: str) -> float:
    """The rate of that policy behind a server, one episode at a time."""
    policies: dict[str, Rememberer] = {}

    def act(request: dict[str, Any]) -> np.ndarray:
        rows = np.atleast_2d(request["observation/objects"])
        tcp = np.atleast_2d(request["observation/state"])[-1, :3]
        told = request["engram"]
        policy = policies.setdefault(told["episode"], Rememberer(layout))
        return policy.act(rows, tcp, told["step"] == 0)

    with openpi_server(act) as url:
        address = f"{url}?history={history}"
        result = engram.evaluate(
            address, TASK, obs="objects", episodes=EPISODES, tell_episodes=True, threads=1
        )
    return result["tasks"][0]["sr"]


@pytest.fixture(scope="module")
def layout() -> Layout:
    return Layout()


def test_a_policy_that_remembers_needs_the_frames_between_two_questions(layout):
    """It sees all three colours or the first one alone."""
    assert success(layout, "since-last") >= 0.9
    assert success(layout, "last") == 0
