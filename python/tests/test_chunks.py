"""Chunks that are cut, and frames between questions, of policies in Python."""

from __future__ import annotations

import json
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import engram

TASK = "RememberColor3-VLA-v0"  # 25 steps
RUN: dict[str, Any] = {"episodes": 3, "num_envs": 2, "threads": 1, "obs": "state"}


class Recorder:
    """Answers chunks of 8 that do not depend on how they are used; keeps its observations."""

    def __init__(self) -> None:
        self.seen: list[dict[str, Any]] = []

    def __call__(self, observation: dict[str, Any]) -> Any:
        self.seen.append(observation)
        return np.zeros((len(observation["instruction"]), 8, 7), np.float32)

    def steps(self, episode: int) -> list[int]:
        """Steps of the questions of one episode, by its number."""
        return [
            int(one["step"][row])
            for one in self.seen
            for row, number in enumerate(one["episode"])
            if number == episode
        ]


def test_replan_cuts_chunks() -> None:
    policy = Recorder()
    result = engram.evaluate(policy, TASK, replan=5, tell_episodes=True, **RUN)
    assert policy.steps(0) == [0, 5, 10, 15, 20]
    (task,) = result["tasks"]
    assert task["action_chunk_size"] == 5
    assert task["model"]["config"] == {"replan": 5}


def every_frame() -> list[dict[str, Any]]:
    """Observations of all steps of the same episodes."""
    seen: list[dict[str, Any]] = []

    def act(observation: dict[str, Any]) -> Any:
        seen.append(observation)
        return np.zeros((len(observation["instruction"]), 7), np.float32)

    engram.evaluate(act, TASK, tell_episodes=True, **RUN)
    return seen


def frame(seen: list[dict[str, Any]], episode: int, step: int) -> dict[str, Any]:
    return next(
        {name: one[name][row] for name in ("state", "proprio")}
        for one in seen
        for row in range(len(one["episode"]))
        if (one["episode"][row], one["step"][row]) == (episode, step)
    )


@pytest.mark.parametrize(
    ("history", "steps"),
    [
        ("since-last", lambda step: list(range(max(0, step - 7), step + 1))),
        ("3,4", lambda step: [max(0, step - 8), max(0, step - 4), step]),
    ],
)
def test_a_policy_sees_the_frames_within_its_chunks(history: str, steps: Any) -> None:
    policy, all_frames = Recorder(), every_frame()
    result = engram.evaluate(policy, TASK, history=history, tell_episodes=True, **RUN)
    assert result["tasks"][0]["model"]["config"] == {"history": history}
    for episode in range(3):
        assert policy.steps(episode) == [0, 8, 16, 24]
    for one in policy.seen:
        for row, frames in enumerate(one["frames"]):
            assert frames["rgb"] is None
            assert frames["step"].tolist() == steps(int(one["step"][row]))
            for place, step in enumerate(frames["step"]):
                shown = frame(all_frames, int(one["episode"][row]), int(step))
                assert (frames["state"][place] == shown["state"]).all()
                assert (frames["proprio"][place] == shown["proprio"]).all()


def test_images_have_a_history() -> None:
    policy = Recorder()
    engram.evaluate(policy, TASK, history="2,3", **{**RUN, "obs": "rgb", "episodes": 1})
    assert [one["frames"][0]["rgb"].shape for one in policy.seen] == [(2, 128, 128, 6)] * 4
    assert all((one["frames"][0]["rgb"][-1] == one["rgb"][0]).all() for one in policy.seen)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"replan": -1}, "replan: -1 given; allowed: 0 to 1000"),
        ({"replan": 9}, "a chunk of 8 given; replan=9 needs as many"),
        ({"history": "all"}, "last, since-last or N,STRIDE"),
    ],
)
def test_refusals(options: dict[str, Any], message: str) -> None:
    with pytest.raises(engram.Error, match=message):
        engram.evaluate(Recorder(), TASK, **options, **RUN)
    with pytest.raises(engram.InvalidArgumentError, match="choices given"):
        engram.evaluate(ids=TASK, choices=lambda question: 0, replan=2, **RUN)


PIPE_POLICY = """
import json, struct, sys
import numpy as np
from engram._io import pipe_messages as pipes

log, width, frames = open(sys.argv[1], "w"), 0, None
while len(head := sys.stdin.buffer.read(8)) == 8:
    kind, size = struct.unpack("<2I", head)
    body = pipes.Reader(sys.stdin.buffer.read(size))
    if kind == 1:
        answer = pipes.packed(1, pipes.SIGNATURE)
    elif kind == 2:
        answer, _ = b"", body.text()
        width = body.number()
    elif kind == 8:
        answer, frames = b"", []
        while not body.at_end:
            count = body.number()
            frames.append(body.array("<i4", count).tolist())
            body.array("<f4", count, 7), body.array("<f4", count, width)
    else:
        count = body.number()
        body.array("<i4", 2, count)
        steps = body.array("<i4", count).tolist()
        print(json.dumps([steps, frames]), file=log, flush=True)
        chunk = struct.pack("<3I", 2, 8, 7) + np.zeros((8, 7), "<f4").tobytes()
        answer = pipes.packed(4, struct.pack("<I", count) + chunk * count)
    sys.stdout.buffer.write(answer)
    sys.stdout.buffer.flush()
"""


def evaluated(folder: Path, *options: str) -> tuple[subprocess.CompletedProcess[str], list[Any]]:
    """A run of the pipe policy, and the steps of its requests and frames."""
    (folder / "policy.py").write_text(PIPE_POLICY)
    log = folder / "log"
    command = shlex.join([sys.executable, str(folder / "policy.py"), str(log)])
    run = subprocess.run(
        [sys.executable, "-m", "engram", "eval", TASK, "--episodes", "1", "--obs", "state",
         "--json", "--policy-command", command, *options],
        capture_output=True, text=True, check=False, timeout=120,
    )  # fmt: skip
    lines = log.read_text().splitlines() if log.exists() else []
    return run, [json.loads(line) for line in lines]


def test_commands_have_chunks_and_histories(tmp_path: Path) -> None:
    run, asked = evaluated(tmp_path, "--replan", "6", "--history", "since-last")
    assert run.returncode == 0, run.stderr
    steps = [[0], [6], [12], [18], [24]]
    frames = [[0], [*range(1, 7)], [*range(7, 13)], [*range(13, 19)], [*range(19, 25)]]
    assert asked == [[one, [shown]] for one, shown in zip(steps, frames)]
    config = json.loads(run.stdout)["tasks"][0]["model"]["config"]
    assert config["replan"] == "6"
    assert config["history"] == "since-last"
    run, asked = evaluated(tmp_path, "--replan", "6")
    assert run.returncode == 0, run.stderr
    assert asked == [[one, None] for one in steps]


def test_lists_of_chunks_and_histories_are_a_sweep(tmp_path: Path) -> None:
    out = tmp_path / "results"
    lists = ["--replan", "5,8", "--history", "last,3,4,since-last"]
    run, _ = evaluated(tmp_path, *lists, "--out", str(out))
    assert run.returncode == 0, run.stderr
    points = [
        (replan, history) for replan in ("5", "8") for history in ("last", "3,4", "since-last")
    ]
    document = json.loads(run.stdout)
    assert [(one["replan"], one["history"]) for one in document] == points
    assert {path.name for path in out.iterdir()} == {f"replan-{r}_history-{h}" for r, h in points}
    for point, (replan, history) in zip(document, points):
        (task,) = point["tasks"]
        assert task["model"]["config"]["replan"] == replan
        assert task["model"]["config"]["history"] == history
        assert point["summary"]["tasks"] == [TASK]
    table, _ = evaluated(tmp_path, *lists[:2])
    assert [row["replan"] for row in json.loads(table.stdout)] == ["5", "8"]
    resumed, _ = evaluated(tmp_path, *lists, "--resume", str(next(out.glob("*/*/*"))))
    assert "one value of each allowed" in resumed.stderr


def test_a_run_with_chunks_is_reproduced(tmp_path: Path) -> None:
    run, _ = evaluated(tmp_path, "--replan", "6", "--history", "2,3", "--out", str(tmp_path))
    assert run.returncode == 0, run.stderr
    folder = next(tmp_path.glob("*/*/settings.json")).parent
    policy = shlex.join([sys.executable, str(tmp_path / "policy.py"), str(tmp_path / "log")])
    for more, verdict in ([], "same"), (["--history", "last"], "policy"):
        again = subprocess.run(
            [sys.executable, "-m", "engram", "reproduce", str(folder), "--json",
             "--policy-command", policy, *more],
            capture_output=True, text=True, check=False, timeout=120,
        )  # fmt: skip
        assert json.loads(again.stdout)["verdict"] == verdict, again.stderr


def test_commands_with_chunks_fail_in_one_sentence(tmp_path: Path) -> None:
    run, _ = evaluated(tmp_path, "--replan", "9")
    assert run.returncode == 1
    assert "a chunk of 8 given; replan=9 needs as many" in run.stderr
    run, _ = evaluated(tmp_path, "--history", "all")
    assert "last, since-last or N,STRIDE" in run.stderr
    ended = subprocess.run(
        [sys.executable, "-m", "engram", "eval", TASK, "--episodes", "1", "--policy-command",
         "exit 3", "--replan", "2"],
        capture_output=True, text=True, check=False, timeout=120,
    )  # fmt: skip
    assert ended.returncode == 1
    assert "it has ended with exit code 3" in ended.stderr
