"""Evaluations during a training: the same episodes, a budget, one record each."""

from __future__ import annotations

import json

import numpy as np
import pytest
from conftest import TASK

import engram
from engram.integrations.periodic import Lockstep, PeriodicEvaluation


class Good:
    """The oracle in some of the episodes, and no motion in the others."""

    def __init__(self, good: set[int]) -> None:
        self.good, self.env, self.asked = good, None, 0

    def __call__(self, observation: dict) -> np.ndarray:
        self.asked += 1
        actions = np.zeros((len(observation["slot"]), 7), np.float32)
        for row, (seed, step) in enumerate(zip(observation["seed"], observation["step"])):
            if int(seed) - 2_000_000_000 in self.good:
                actions[row] = self._oracle(int(seed))[int(step)]
        return actions

    def _oracle(self, seed: int) -> np.ndarray:
        known = _ORACLES.get(seed)
        if known is None:
            env = engram.make(TASK)
            env.reset(seed=seed)
            actions, ended = [], False
            while not ended:
                actions.append(env.act("oracle"))
                _, _, terminated, truncated, _ = env.step(actions[-1])
                ended = terminated or truncated
            env.close()
            known = _ORACLES[seed] = np.stack([*actions, actions[-1]])
        return known


_ORACLES: dict[int, np.ndarray] = {}


def evaluation(**options) -> PeriodicEvaluation:
    given = {"every": 100, "episodes": 8, "num_envs": 4, "obs": "state", "tell_episodes": True}
    return PeriodicEvaluation(TASK, **{**given, **options})


def test_it_is_due_after_each_number_of_steps():
    periodic = evaluation(episodes=2)
    policy = Good({0})
    given = [periodic(step, policy) for step in (0, 50, 99, 130, 200, 230)]
    assert [record["step"] if record else None for record in given] == [
        0, None, None, 130, None, 230,
    ]  # fmt: skip
    assert periodic.records == [record for record in given if record]


def test_a_record_has_rates_answers_and_the_change_since_the_last():
    periodic = evaluation()
    first = periodic.run(0, Good({0, 1, 2}))
    second = periodic.run(100, Good({1, 2, 3, 4, 5, 6, 7}))
    expected = engram.evaluate(
        Good({0, 1, 2}), TASK, episodes=8, seed=2_000_000_000, obs="state", tell_episodes=True
    )["tasks"][0]
    assert (first["episodes"], first["success"]) == (8, 0.375)
    assert first["success"] == expected["sr"]
    assert [first["low"], first["high"]] == pytest.approx(expected["sr_interval"])
    assert first["first_answer"] == expected["first_answer_correct"]
    assert first["chance"] == expected["chance"]
    assert (first["pairs"], first["p_value"]) == (0, 1)
    assert (second["pairs"], second["gained"], second["lost"]) == (8, 5, 1)
    assert second["p_value"] == pytest.approx(2 * (1 + 6) / 64)  # McNemar's exact test


def test_it_stops_by_episodes_seconds_or_a_narrow_interval():
    assert evaluation().run(0, Good(set()))["stopped"] == "episodes"
    record = evaluation(episodes=1000, seconds=1e-9).run(0, Good(set()))
    assert (record["episodes"], record["stopped"]) == (4, "seconds")
    record = evaluation(episodes=1000, width=0.4).run(0, Good(set()))
    assert (record["episodes"], record["stopped"]) == (8, "width")
    assert record["high"] - record["low"] <= 0.4


def test_records_are_kept_in_a_file(tmp_path):
    periodic = evaluation(episodes=2, file=tmp_path / "curve.jsonl")
    for step in (0, 100):
        periodic(step, Good({0}))
    lines = (tmp_path / "curve.jsonl").read_text().splitlines()
    assert [json.loads(line) for line in lines] == periodic.records


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"every": 0}, "every: 0 given"),
        ({"seconds": 0}, "seconds: 0 given, more than 0 needed"),
        ({"width": 2}, "width: 2 given, more than 0 and at most 1 needed"),
        ({"episodes": 0}, "episodes: 0 given"),
    ],
)
def test_refused(options, message):
    with pytest.raises(engram.InvalidArgumentError, match=message):
        evaluation(**options)


def test_a_policy_of_whole_batches_needs_episodes_that_begin_together():
    seen = []

    def act(rows: dict, begins: np.ndarray) -> np.ndarray:
        seen.append((rows["state"][:, 0].tolist(), begins.tolist(), list(rows["instruction"])))
        return rows["state"]

    def question(slots: list[int], first: list[int], values: list[float]) -> dict:
        column = np.array(values, np.float32)[:, None]
        return {
            "slot": np.array(slots), "first": np.array(first), "state": column, "proprio": column,
            "rgb": None, "step": np.zeros(len(slots)), "instruction": [str(v) for v in values],
        }  # fmt: skip

    policy = Lockstep(act)
    assert policy(question([1, 0], [1, 1], [5, 4])).tolist() == [[5], [4]]
    assert policy(question([1], [0], [6])).tolist() == [[6]]
    assert seen == [
        ([4, 5], [True, True], ["4", "5"]),
        ([4, 6], [False, False], ["4", "6"]),
    ]
    for slots, first in (([0, 1], [0, 1]), ([1], [1])):
        with pytest.raises(engram.InvalidArgumentError, match="do not begin together"):
            policy(question(slots, first, [1.0] * len(slots)))
