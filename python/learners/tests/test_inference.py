"""engram_learners: inference with trained policies, by engram.evaluate and over pipes."""

from __future__ import annotations

import hashlib
import json
import struct
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from programs import SOURCE, TASK, find_objects, learners, run, torch

import engram

HELLO, CHUNKS, FAILED, IDENTITY = 1, 4, 5, 9
SEEDS = 4242424242
EPISODES = 4


def untrained(env: Any, memory: bool = True) -> Any:
    """A policy whose weights are large enough to move the robot and to depend on the memory."""
    torch.manual_seed(3)
    policy = learners.policy.Policy(env.layout, memory=memory)
    policy.fit(env.reset(seed=1)[None])
    with torch.no_grad():
        for weight in policy.act.parameters():
            weight += 0.15 * torch.randn_like(weight)
    return policy


@pytest.fixture(scope="module")
def policy() -> Any:
    return untrained(learners.training.ObjectsEnv(TASK, 4))


@pytest.fixture(scope="module")
def agent(policy: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("agent") / "agent.pt"
    learners.checkpoints.save_policy(policy, path, TASK)
    return path


@torch.no_grad()
def lockstep(policy: Any, env: Any) -> tuple[np.ndarray, np.ndarray]:
    """All episodes at once, as learners play them: returns, actions (T, N, 7)."""
    rows, state, returns, actions = env.reset(seed=SEEDS), None, 0.0, []
    for _ in range(env.horizon):
        choice, _, state, _ = policy(rows[None], state)
        actions.append(choice.best()[0].numpy())
        rows, rewards = env.step(choice.best()[0])
        returns = returns + rewards.double().numpy()
    return returns, np.array(actions)


def returns_of(runner: Any, obs: str, task: str = TASK, **options: Any) -> list[float]:
    result = engram.evaluate(runner, task, obs=obs, episodes=EPISODES, threads=1, **options)
    return result["tasks"][0]["returns"]


def test_an_evaluation_plays_as_learners_do(policy: Any) -> None:
    expected, actions = lockstep(policy, learners.training.ObjectsEnv(TASK, EPISODES))
    assert np.ptp(actions[-1], axis=0).max() > 0.01  # the episodes differ
    runner = learners.inference.PolicyRunner(policy, task=TASK)
    # Torch's last bits depend on the size of a batch, and contacts magnify them.
    same = {"rtol": 0, "atol": 0.02}
    assert np.diff(np.sort(expected)).min() > 2 * same["atol"]
    np.testing.assert_allclose(returns_of(runner, "objects", num_envs=50), expected, **same)
    # One runner with its slots, new episodes: the old memories are gone.
    np.testing.assert_allclose(returns_of(runner, "objects", num_envs=1), expected, **same)


@pytest.mark.parametrize("task", [TASK, "RotateLenientPos-VLA-v0"])
def test_an_evaluation_from_pictures_plays_as_learners_do(task: str) -> None:
    env = learners.images.rgb_env.RgbEnv(task, EPISODES)
    find_objects(env.detector)
    policy = untrained(env)
    expected, _ = lockstep(policy, env)
    assert (env.found.known >= 0).any()
    runner = learners.inference.PolicyRunner(policy, env.detector, task)
    assert runner.obs == "rgb"
    returns = returns_of(runner, "rgb", task, num_envs=50)
    np.testing.assert_allclose(returns, expected, atol=1e-3)


def requests(count: int = EPISODES) -> list[dict[str, Any]]:
    """Requests of an evaluation: the oracle's episodes in that many slots."""
    batch = engram.make_vec(TASK, count, obs_mode="objects", threads=1, copy=True)
    rows, asked = batch.reset(seed=SEEDS)[0], []
    for step in range(12):
        asked.append(
            {"state": rows, "worker": 0, "slot": np.arange(count), "first": [step == 0] * count}
        )
        rows = batch.step(batch.act("oracle"))[0]
    batch.close()
    return asked


def part(request: dict[str, Any], which: list[int], slots: list[int]) -> dict[str, Any]:
    first = [request["first"][i] for i in which]
    return {"state": request["state"][which], "worker": 1, "slot": slots, "first": first}


def test_memories_follow_slots_whatever_the_order_of_rows(policy: Any) -> None:
    runner = learners.inference.PolicyRunner(policy, task=TASK)
    asked = requests()
    expected = [runner(request) for request in asked]
    # Two at a time, in another order, in places of their own.
    for request, actions in zip(asked, expected):
        for which, slots in (([3, 0], [7, 2]), ([1, 2], [0, 5])):
            answer = runner(part(request, which, slots))
            np.testing.assert_allclose(answer, actions[which], atol=1e-5)


def test_memories_last_until_a_new_episode(policy: Any) -> None:
    runner = learners.inference.PolicyRunner(policy, task=TASK)
    asked = requests()
    for request in asked[:-1]:
        runner(request)
    kept = runner(asked[-1])
    new = runner({**asked[-1], "first": [False, True, False, True]})
    fresh = learners.inference.PolicyRunner(policy, task=TASK)(
        {**asked[-1], "first": [True] * EPISODES}
    )
    np.testing.assert_allclose(new[[1, 3]], fresh[[1, 3]], atol=1e-5)
    assert np.abs(kept - fresh).max(-1).min() > 1e-3


def test_a_wiped_memory_begins_anew_when_objects_appear(policy: Any, agent: Path) -> None:
    wiped = learners.inference.load_runner(agent, forget=True)
    plain, begun = (learners.inference.PolicyRunner(policy, task=TASK) for _ in range(2))
    before = np.zeros(EPISODES)
    for request in requests():
        tokens = policy.layout.split(torch.from_numpy(request["state"]))[1]
        seen = tokens[..., 0].sum(-1).numpy()
        expected = begun({**request, "first": seen > before})
        before, kept = seen, plain(request)
        np.testing.assert_allclose(wiped(request), expected, atol=1e-5)
    assert (seen == 3).all()
    assert np.abs(expected - kept).max(-1).min() > 1e-3  # the cue is forgotten


def test_a_policy_without_memory_plays_too() -> None:
    env = learners.training.ObjectsEnv(TASK, EPISODES)
    policy = untrained(env, memory=False)
    expected, _ = lockstep(policy, env)
    runner = learners.inference.PolicyRunner(policy, task=TASK)
    np.testing.assert_allclose(returns_of(runner, "objects"), expected, atol=1e-3)


def test_other_observations_are_refused(policy: Any) -> None:
    runner = learners.inference.PolicyRunner(policy, task=TASK)
    with pytest.raises(ValueError, match="obs objects needed"):
        returns_of(runner, "rgb")
    with pytest.raises(ValueError, match=f"35 numbers given, {runner.width} needed"):
        returns_of(runner, "state")


class Pipe:
    """engram's end of the pipes to serve.py (docs/evaluation.md)."""

    def __init__(self, agent: Path) -> None:
        self.agent = agent
        command = [sys.executable, "-m", "engram_learners.serve", str(agent)]
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE
        )

    def send(self, kind: int, body: bytes) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(struct.pack("<II", kind, len(body)) + body)
        self.process.stdin.flush()

    def receive(self) -> tuple[int, bytes]:
        assert self.process.stdout is not None
        kind, size = struct.unpack("<II", self.process.stdout.read(8))
        return kind, self.process.stdout.read(size)

    def greet(self, observes: int, width: int) -> None:
        self.send(1, struct.pack("<9I", 0x4D474E45, 1, observes, 0, 0, 0, 7, 7, EPISODES))
        kind, identity = self.receive()
        assert kind == IDENTITY
        checkpoint = f"sha256:{hashlib.sha256(self.agent.read_bytes()).hexdigest()}"
        assert json.loads(identity) == {
            "policy": self.agent.name, "checkpoint": checkpoint, "wiped": False
        }  # fmt: skip
        assert self.receive() == (HELLO, struct.pack("<II", 0x4D474E45, 1))
        self.send(2, struct.pack("<I", len(TASK)) + TASK.encode() + struct.pack("<I", width))

    def ask(self, request: dict[str, Any], step: int) -> tuple[int, bytes]:
        count = len(request["slot"])
        numbers = [*request["slot"], *range(count), *[step] * count]
        body = struct.pack(f"<I{3 * count}i", count, *numbers) + bytes(request["first"])
        body += (struct.pack("<I", 2) + b"do") * count + bytes(4 * 7 * count)
        self.send(3, body + request["state"].tobytes())
        return self.receive()

    def close(self) -> int:
        self.process.communicate(timeout=60)
        return self.process.returncode


def actions_in(body: bytes) -> np.ndarray:
    """Actions (N, 7), each of which is a chunk of shape (1, 7)."""
    count, *_ = struct.unpack_from("<I", body)
    chunks = np.frombuffer(body[4:], np.dtype([("shape", "<u4", 3), ("action", "<f4", 7)]))
    assert chunks["shape"].tolist() == [[2, 1, 7]] * count
    return chunks["action"]


def test_a_process_answers_as_the_runner_does(policy: Any, agent: Path) -> None:
    runner, pipe, asked = (
        learners.inference.PolicyRunner(policy, task=TASK),
        Pipe(agent),
        requests(),
    )
    pipe.greet(3, runner.width)
    for step, request in enumerate(asked):
        kind, body = pipe.ask(request, step)
        assert kind == CHUNKS
        np.testing.assert_array_equal(actions_in(body), runner(request))
    assert pipe.close() == 0


def test_a_process_reports_unreadable_observations(agent: Path) -> None:
    pipe = Pipe(agent)
    pipe.greet(2, 35)
    request = {"state": np.zeros((1, 35), np.float32), "slot": [0], "first": [True]}
    kind, body = pipe.ask(request, 0)
    assert kind == FAILED
    assert "35 numbers given" in body.decode()
    assert pipe.close() != 0


def test_a_policy_is_compared_with_others(agent: Path) -> None:
    figures = json.loads(run("evaluate", str(agent), "--episodes", "3", "--json")[0])
    known = engram.describe(TASK)
    assert (figures["id"], figures["episodes"], figures["seed"]) == (TASK, 3, SEEDS)
    assert figures["policy"]["success_once"] in (0, 1 / 3, 2 / 3, 1)
    assert figures["chance"]["success_once"] == known["chance"]
    for who in ("sweep", "oracle"):
        assert figures[who] == known["ceilings"][who]
    lines = run("evaluate", str(agent), "--episodes", "3")
    assert lines[-1].split() == ["oracle", "1.00", "1.00"]


def test_rllib_workers_report_missing_ray() -> None:
    hidden = "import sys, runpy; sys.modules['ray'] = None; runpy.run_path(sys.argv[1])"
    command = [sys.executable, "-c", hidden, str(SOURCE / "rllib_workers.py")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "ray is missing: pip install" in done.stderr
    assert "Traceback" not in done.stderr


def test_an_agent_behind_a_policy_server(agent: Path) -> None:
    """`engram serve` with the loader of the examples."""
    runner = learners.inference.PolicyRunner.load(agent)
    loader = f"{SOURCE / 'inference.py'}:PolicyRunner.load"
    command = [sys.executable, "-m", "engram", "serve", "--port", "0", "--policy", str(agent)]
    with subprocess.Popen(
        [*command, "--loader", loader], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        url = process.stdout.readline().split()[-1]
        result = engram.evaluate(url, TASK, obs="objects", episodes=EPISODES, threads=1)
        with pytest.raises(engram.UnavailableError, match="obs objects needed"):
            engram.evaluate(url, TASK, episodes=1)
        process.terminate()
    assert result["tasks"][0]["returns"] == returns_of(runner, "objects", num_envs=1)
