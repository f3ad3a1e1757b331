"""engram.evaluate: what a policy sees, what it may answer, and how it fails."""

import contextlib
import hashlib
import json
import re

import numpy as np
import pytest

import engram

ID = "RememberColor3-VLA-v0"


def still(observation):
    return np.zeros((len(observation["instruction"]), 7), np.float32)


def test_observations_and_results():
    seen = []

    def policy(observation):
        seen.append(len(observation["instruction"]))
        count = seen[-1]
        assert observation["rgb"].shape == (count, 128, 128, 6)
        assert observation["rgb"].dtype == np.uint8
        assert observation["rgb"].std() > 1
        assert observation["proprio"].shape == (count, 7)
        assert observation["state"] is None
        assert observation["env_id"] == ID
        assert min(observation["episode"]) > 2  # opaque
        assert "seed" not in observation
        assert ((observation["step"] == 0) == (observation["first"] == 1)).all()
        return np.zeros((count, 5, 7), np.float32)

    result = engram.evaluate(policy, ID, episodes=3, num_envs=2, name="still")
    task = result["tasks"][0]
    assert task["env_id"] == ID
    assert task["action_chunk_size"] == 5
    assert task["model"]["name"] == "still"
    assert task["episode_seeds"] == [4242424242, 4242424243, 4242424244]
    assert sum(seen) == 3 * 5  # 25 steps in chunks of 5
    # Standing still by hand gives the same returns.
    env = engram.make(ID, obs_mode="state")
    for episode in range(3):
        env.reset(seed=4242424242 + episode)
        total = sum(env.step(np.zeros(7, np.float32))[1] for _ in range(25))
        assert task["returns"][episode] == pytest.approx(total, rel=1e-6)


def test_same_for_any_batch():
    def policy(observation):
        pixels = observation["rgb"][:, ::16, ::16].reshape(len(observation["episode"]), -1)
        angle = pixels.mean(axis=1)
        actions = np.zeros((len(angle), 7), np.float32)
        actions[:, 0], actions[:, 1] = np.cos(angle), np.sin(angle)
        return [action[None, None] for action in actions]  # (1, 1, 7)

    results = [
        engram.evaluate(policy, ID, episodes=5, num_envs=num_envs, threads=threads)
        for num_envs, threads in [(1, 1), (2, 2), (5, 1)]
    ]
    assert results[0] == results[1] == results[2]


def test_episodes_are_told_on_request_only(tmp_path):
    seen = {}

    def policy(observation):
        for episode, seed in zip(observation["episode"], observation["seed"]):
            seen[int(episode)] = int(seed)
        return still(observation)

    task = engram.evaluate(policy, ID, episodes=3, obs="state", tell_episodes=True)["tasks"][0]
    assert seen == {i: 4242424242 + i for i in range(3)}
    assert task["tell_episodes"] is True
    numbers = []

    def other(observation):
        numbers.append(observation["episode"].tolist())
        return still(observation)

    for num_envs in (1, 3):
        engram.evaluate(other, ID, episodes=3, obs="state", num_envs=num_envs, threads=1)
    # Equal in every run.
    assert {n for part in numbers[:75] for n in part} == {n for part in numbers[75:] for n in part}
    with pytest.raises(engram.InvalidArgumentError, match="tell_episodes"):
        engram.evaluate(still, ID, tell_episodes=2)


def test_a_sealed_evaluation(tmp_path):
    secret = "0123456789abcdef" * 2 + "\n"
    file = tmp_path / "seed"
    file.write_text(secret)
    result = engram.evaluate(still, ID, episodes=2, obs="state", seed_file=file, output=tmp_path)
    task = result["tasks"][0]
    assert task["sealed"] == {
        "sha256": hashlib.sha256(secret.encode()).hexdigest(),
        "secret": secret,
    }
    again = engram.evaluate(still, ID, episodes=2, obs="state", seed=task["start_seed"])
    assert again["tasks"][0]["returns"] == task["returns"]
    (folder,) = (tmp_path / "short").iterdir()
    arguments = {"episodes": 2, "obs": "state", "resume": folder}
    assert engram.evaluate(still, ID, **arguments, seed_file=file) == result
    with pytest.raises(engram.InvalidArgumentError, match="other options"):
        engram.evaluate(still, ID, **arguments)
    file.write_text("42\n")
    with pytest.raises(engram.InvalidArgumentError, match="2 characters given"):
        engram.evaluate(still, ID, seed_file=file)
    with pytest.raises(engram.InvalidArgumentError, match="one of them allowed"):
        engram.evaluate(still, ID, seed_file=file, tell_episodes=True)


def test_state_only_on_request():
    def policy(observation):
        assert observation["rgb"] is None
        assert observation["state"].shape[1] > 25
        return still(observation)

    task = engram.evaluate(policy, ID, episodes=1, obs="state")["tasks"][0]
    assert task["obs_mode"] == "state"


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        (lambda n: np.zeros((n, 0, 7)), "empty chunk"),
        (lambda n: np.zeros((n, 6)), "shape"),
        (lambda n: np.zeros((n + 1, 7)), "rows"),
        (lambda n: np.full((n, 7), np.nan), "finite"),
        (lambda n: np.full((n, 7), 1j), "complex128 given, real numbers needed"),
        (lambda n: [np.full(7, 1j)] * n, "row 0: dtype complex128"),
        (lambda n: np.ma.masked_greater(np.ones((n, 7)), 0), "masked values"),
        (lambda n: [np.ma.masked_greater(np.ones(7), 0)] * n, "masked values"),
        (lambda n: np.full((n, 7), "1"), "real numbers needed"),
        (lambda n: np.full((n, 7), True), "real numbers needed"),
    ],
)
def test_bad_answers(answer, message):
    with pytest.raises(engram.InvalidArgumentError, match=message):
        engram.evaluate(lambda o: answer(len(o["instruction"])), ID, episodes=1, obs="state")


def test_exceptions_come_out_as_they_are():
    class MineError(Exception):
        pass

    def policy(observation):
        raise MineError("so it is")

    with pytest.raises(MineError, match="so it is"):
        engram.evaluate(policy, ID, episodes=2, obs="state")

    def progress(*_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        engram.evaluate(still, ID, episodes=500, obs="state", progress=progress)


def test_files_and_resume(tmp_path):
    ids = [ID, "RememberColor5-VLA-v0"]
    result = engram.evaluate(still, ids, episodes=2, obs="state", output=tmp_path)
    (folder,) = (tmp_path / "short").iterdir()
    assert json.loads((folder / "summary.json").read_text()) == result["summary"]
    (folder / f"{ID}.json").unlink()
    asked = []

    def policy(observation):
        asked.append(observation["env_id"])
        return still(observation)

    assert engram.evaluate(policy, ids, episodes=2, obs="state", resume=folder) == result
    assert set(asked) == {ID}
    with pytest.raises(engram.InvalidArgumentError, match="other options"):
        engram.evaluate(policy, ids, episodes=3, obs="state", resume=folder)


def test_results_have_the_rules():
    assert engram.evaluate(still, ID, episodes=1)["tasks"][0]["rules"] == "reference"
    result = engram.evaluate(still, ID, episodes=1, rules="original")
    assert result["tasks"][0]["rules"] == "original"
    with pytest.raises(engram.Error, match="rules: 'upstream' given; allowed: reference, original"):
        engram.evaluate(still, ID, episodes=1, rules="upstream")


def test_wrong_arguments():
    with pytest.raises(engram.UnknownIdError):
        engram.evaluate(still, "RememberColour3-VLA-v0")
    with pytest.raises(engram.InvalidArgumentError):
        engram.evaluate(still, [])
    with pytest.raises(engram.InvalidArgumentError):
        engram.evaluate(still, ID, episodes=0)


def test_rounds_have_policy_seeds():
    seen = set()

    def policy(observation):
        seen.add(observation["policy_seed"])
        actions = still(observation)
        actions[:, 0] = observation["policy_seed"] / 10
        return actions

    arguments = {"episodes": 2, "obs": "state"}
    task = engram.evaluate(policy, ID, **arguments, repeat=2, policy_seed=4)["tasks"][0]
    assert seen == {4, 5}
    assert (task["n_episodes"], task["repeat"], task["policy_seed"]) == (4, 2, 4)
    assert task["episode_seeds"] == [4242424242, 4242424243] * 2
    single = engram.evaluate(policy, ID, **arguments, policy_seed=5)["tasks"][0]
    assert single["returns"] == task["returns"][2:]
    assert task["digests"]["first_observations"][:2] == task["digests"]["first_observations"][2:]
    plain = engram.evaluate(still, ID, **arguments)["tasks"][0]
    assert not {"repeat", "policy_seed", "latency_steps"} & set(plain)
    with pytest.raises(engram.InvalidArgumentError, match="repeat: 0 given, 1 to 1000 allowed"):
        engram.evaluate(still, ID, repeat=0)
    with pytest.raises(engram.InvalidArgumentError, match="policy_seed"):
        engram.evaluate(still, ID, policy_seed=-1)


def test_latency():
    steps = []

    def policy(observation):
        steps.extend(observation["step"].tolist())
        return np.full((len(observation["instruction"]), 2, 7), 0.3, np.float32)

    arguments = {"episodes": 1, "obs": "state"}
    late = engram.evaluate(policy, ID, **arguments, latency=3)["tasks"][0]
    assert steps == list(range(0, 25, 5))  # three steps of waiting, two of acting
    assert late["latency_steps"] == 3
    assert engram.evaluate(policy, ID, **arguments, latency="120ms")["tasks"][0] == late
    prompt = engram.evaluate(policy, ID, **arguments)["tasks"][0]
    assert engram.evaluate(policy, ID, **arguments, latency="0ms")["tasks"][0] == prompt
    # What comes too late is never done.
    never = engram.evaluate(policy, ID, **arguments, latency=25)["tasks"][0]
    assert (
        never["returns"]
        == engram.evaluate(still, ID, **arguments, latency=25)["tasks"][0]["returns"]
    )
    assert never["returns"] != prompt["returns"]
    for bad in ("soon", -1, 2.5, True):
        with pytest.raises(engram.InvalidArgumentError, match="latency"):
            engram.evaluate(policy, ID, latency=bad)


def test_joint_space():
    """Actions and proprio of joints; the oracle of another batch solves the episodes."""
    twin = engram.make(ID, control_mode="pd_joint_pos", joint_proprio=True, obs_mode="state")
    seen = set()

    def policy(observation):
        seen.add((observation["proprio"].shape, observation["state"].shape))
        if observation["first"][0]:
            twin.reset(seed=int(observation["seed"][0]))
        action = twin.act("oracle")
        _, _, _, _, info = twin.step(action)
        seen.add(info["proprio"].shape)
        return action[None]

    with contextlib.closing(twin):
        result = engram.evaluate(
            policy, ID, episodes=3, num_envs=1, threads=1, obs="state", tell_episodes=True,
            control_mode="pd_joint_pos", joint_proprio=True,
        )  # fmt: skip
    task = result["tasks"][0]
    assert task["successes"] == [True] * 3
    assert (task["control_mode"], task["joint_proprio"]) == ("pd_joint_pos", True)
    assert {shape for shape in seen if len(shape) == 1} == {(8,)}
    assert {shape[0] for shape in seen if len(shape) == 2} == {(1, 8)}
    with pytest.raises(engram.UnknownIdError, match="no control mode named 'pd'"):
        engram.evaluate(policy, ID, control_mode="pd")


def test_a_suite():
    assert engram.suites()["mikasa5"]["episodes"] == 100
    asked = []

    def still(observation):
        asked.append(observation["env_id"])
        return np.zeros((len(observation["instruction"]), 30, 7))

    result = engram.evaluate(still, suite="mikasa5", episodes=1, obs="state")
    assert {task["env_id"] for task in result["tasks"]} == set(engram.suites()["mikasa5"]["ids"])
    assert set(asked) == set(engram.suites()["mikasa5"]["ids"])
    for wrong, words in (
        ({"suite": "mikasa6"}, "suite: 'mikasa6' given, mikasa5 allowed"),
        ({"suite": "mikasa5", "ids": ID}, "ids, suite: one of them allowed"),
        ({}, "ids: None given"),
    ):
        with pytest.raises(engram.InvalidArgumentError, match=re.escape(words)):
            engram.evaluate(still, **wrong)
