"""engram_learners: the nine memories, the learners that use them, and their comparison.

python/tests/clients/apart/test_memories.py holds them against their released implementations.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from programs import TASK, learners, run, torch

import engram

NAMES = ("none", "stack4", "gru", "lstm", "mingru", "lru", "mamba", "gtrxl", "xlstm")
OTHER = "FindImposterColor3-VLA-v0"  # with as many objects
STEPS, ENVS = 90, 3  # more than the window of gtrxl


def made(name: str) -> tuple[Any, Any]:
    """A memory and inputs."""
    torch.manual_seed(0)
    return learners.memories.make(name), torch.randn(STEPS, ENVS, learners.memories.WIDTH)


def same(one: Any, other: Any) -> None:
    torch.testing.assert_close(one, other, rtol=1e-4, atol=1e-5)


# --- the memories ---


@pytest.mark.parametrize("name", NAMES)
@torch.no_grad()
def test_single_steps_equal_a_whole_sequence(name: str) -> None:
    memory, inputs = made(name)
    whole, last = memory(inputs)
    assert whole.shape == inputs.shape
    outputs, state = [], None
    for step in inputs:
        one, state = memory(step[None], state)
        outputs.append(one)
    same(torch.cat(outputs), whole)
    for one, other in zip(state, last):
        same(one, other)


@pytest.mark.parametrize("name", NAMES)
@torch.no_grad()
def test_a_reset_forgets_and_touches_no_other_episode(name: str) -> None:
    memory, inputs = made(name)
    begins = torch.zeros(STEPS, ENVS, dtype=torch.bool)
    begins[20, 1] = begins[50, 2] = True
    outputs, state = memory(inputs, None, begins)
    plain, _ = memory(inputs)
    same(outputs[:, 0], plain[:, 0])
    same(outputs[20:, 1:2], memory(inputs[20:, 1:2])[0])
    same(outputs[50:, 2:], memory(inputs[50:, 2:])[0])
    for one, other in zip(state, memory(inputs[50:, 2:])[1]):
        same(one[2:], other)
    if name != "none":  # without the reset the past is there
        assert (outputs[20, 1] - plain[20, 1]).abs().max() > 1e-3


@pytest.mark.parametrize("name", NAMES)
def test_how_far_a_memory_reaches(name: str) -> None:
    """The derivative of a step's output by the inputs before it, all of them or the last few."""
    memory, inputs = made(name)
    inputs.requires_grad_()
    memory(inputs)[0][70].square().sum().backward()
    reached = inputs.grad.abs().amax((1, 2)) > 0
    assert not reached[71:].any()  # nothing comes from the future
    reach = {"none": 0, "stack4": 3, "gtrxl": 64}.get(name)
    if reach is None:
        assert reached[50:71].all()
    else:
        assert reached[:71].nonzero()[:, 0].tolist() == list(range(70 - reach, 71))


def test_all_have_equally_many_parameters() -> None:
    counts = {
        n: learners.memories.parameters(learners.memories.make(n))
        for n in learners.memories.MEMORIES
    }
    assert tuple(counts) == NAMES
    for count in counts.values():
        assert abs(count - learners.memories.PARAMETERS) < 0.03 * learners.memories.PARAMETERS
    small = learners.memories.make("gru", budget=8_000)
    assert abs(learners.memories.parameters(small) - 8_000) < 300


def test_the_search_for_a_size_leaves_the_seed_alone() -> None:
    torch.manual_seed(1)
    first = learners.memories.make("lru")
    torch.manual_seed(1)
    second = learners.memories.make("lru", size=first.size)
    for one, other in zip(first.parameters(), second.parameters()):
        assert torch.equal(one, other)


def test_an_unknown_memory_is_refused() -> None:
    with pytest.raises(ValueError, match="memory 'ram' given; allowed: none, stack4, gru"):
        learners.memories.make("ram")


@pytest.mark.parametrize("kind", ["loop", "associative_scan"])
@pytest.mark.parametrize("dtype", ["float64", "complex128"])
def test_a_scan_is_the_recurrence(kind: str, dtype: str) -> None:
    torch.manual_seed(0)
    dtype = getattr(torch, dtype)
    decay, inputs = (torch.randn(7, 2, 3, dtype=dtype, requires_grad=True) for _ in range(2))
    state = torch.randn(2, 3, dtype=dtype, requires_grad=True)
    scan, states, last = getattr(learners.memories.scan, kind), [], state
    for t in range(7):
        last = decay[t] * last + inputs[t]
        states.append(last)
    same(scan(decay, inputs, state), torch.stack(states))
    assert torch.autograd.gradcheck(scan, (decay, inputs, state))


@torch.no_grad()
def test_attention_is_that_of_transformer_xl() -> None:
    """Step by step from the paper's formula, with its four terms."""
    torch.manual_seed(0)
    attention = learners.memories.gtrxl.RelativeAttention(8, 2, window=5)
    for bias in (attention.content_bias, attention.distance_bias):
        bias.normal_()
    before, steps = torch.randn(1, 3, 8), torch.randn(1, 6, 8)
    result = attention(steps, before, torch.tensor([[False, True, True]]))[0]
    all_steps = torch.cat([before, steps], 1)[0]
    keys, values = attention.key_and_value(all_steps).chunk(2, -1)
    for i in range(6):
        heads = []
        for head in range(2):
            part = slice(4 * head, 4 * head + 4)
            query = attention.query(steps[0, i])[part]
            matches, seen = [], range(max(1, i + 3 - 5), i + 4)  # the first step does not exist
            for j in seen:
                far = attention.distance(attention.sines[i + 3 - j])[part]
                by_content = (query + attention.content_bias[head, 0]) @ keys[j, part]
                by_distance = (query + attention.distance_bias[head, 0]) @ far
                matches.append((by_content + by_distance) / math.sqrt(4))
            heads.append(torch.stack(matches).softmax(0) @ values[seen[0] : seen[-1] + 1, part])
        same(result[i], attention.output(torch.cat(heads)))


# --- the policy ---


def rows_of(envs: int = 4, task: str = TASK) -> tuple[Any, Any]:
    """The oracle's episodes (T, N, D), and their layout."""
    env = learners.training.ObjectsEnv(task, envs, 3)
    rows = [env.reset(seed=3)]
    for _ in range(env.horizon - 1):
        rows.append(env.step(env.oracle())[0])
    return torch.stack(rows), env.layout


def policy_of(name: str, rows: Any, layout: Any) -> Any:
    """An untrained policy whose weights are large enough to depend on the memory."""
    torch.manual_seed(3)
    policy = learners.zoo.policy.ZooPolicy(layout, name)
    policy.fit(rows)
    with torch.no_grad():
        for weight in policy.act.parameters():
            weight += 0.15 * torch.randn_like(weight)
    return policy


@pytest.mark.parametrize("name", NAMES)
@torch.no_grad()
def test_a_policy_in_steps_with_a_wiped_memory(name: str) -> None:
    rows, layout = rows_of()
    policy = policy_of(name, rows, layout)
    whole, state = policy(rows)[0], None
    for t, row in enumerate(rows):
        choice, _, state, _ = policy(row[None], state)
        same(choice.mean[0], whole.mean[t])
        same(choice.weights[0], whole.weights[t])
    which = torch.tensor([True, False, True, False])
    state = policy(rows[:12])[2]
    wiped = policy(rows[12:13], policy.reset_state(state, which))[0].mean[0]
    kept = policy(rows[12:13], state)[0].mean[0]
    fresh = policy(rows[12:13])[0].mean[0]
    same(wiped[which], fresh[which])
    same(wiped[~which], kept[~which])
    assert policy.memory == (name != "none")
    assert ((fresh - kept).abs().amax() > 1e-4) == policy.memory


@torch.no_grad()
def test_the_order_of_objects_does_not_matter() -> None:
    rows, layout = rows_of()
    policy = policy_of("gru", rows, layout)
    agent, tokens = layout.split(rows)
    turned = torch.cat([agent, tokens.flip(-2).flatten(-2)], -1)
    same(policy(turned)[0].best(), policy(rows)[0].best())


@torch.no_grad()
def test_an_untrained_policy_of_joints_rests() -> None:
    """Eight numbers in the RL tasks; the way to an object is no motion of joints."""
    rows, layout = rows_of(task="RememberColor3-v0")
    policy = learners.zoo.policy.ZooPolicy(layout, "gru")
    policy.fit(rows)
    mean = policy(rows)[0].mean
    assert mean.shape[-1] == 8
    assert mean.abs().max() < 0.1


@pytest.mark.parametrize("name", ["stack4", "lru", "gtrxl"])
def test_an_agent_plays_by_engrams_programs(tmp_path: Path, name: str) -> None:
    """In `engram.evaluate`, whatever the batch; as a process with pipes; in `engram.probe`."""
    rows, layout = rows_of()
    path = tmp_path / "agent.pt"
    learners.checkpoints.save_policy(policy_of(name, rows, layout), path, TASK)
    runner = learners.inference.load_runner(path)
    assert (runner.policy.kind, runner.obs, runner.task) == (name, "objects", TASK)
    options = {"obs": "objects", "episodes": 4, "threads": 1}

    def rounded(observation: dict[str, Any]) -> Any:
        """Torch's last bits depend on the size of a batch, and contacts magnify them."""
        return np.round(runner(observation), 2)

    def returns(policy: Any, envs: int) -> Any:
        return engram.evaluate(policy, TASK, num_envs=envs, **options)["tasks"][0]["returns"]

    np.testing.assert_allclose(returns(rounded, 4), returns(rounded, 1), rtol=0, atol=0.02)
    together = returns(runner, 4)
    probed = engram.probe(runner, TASK, obs="objects", probes=["twins"], episodes=2)
    assert probed["tasks"][0]["twins"]["presents"]["equal"] == 10
    policy = f"{sys.executable} -m engram_learners.serve {path}"
    command = [sys.executable, "-m", "engram", "eval", TASK, "--obs", "objects", "--json"]
    command += ["--policy-command", policy, "--episodes", "4", "--threads", "1", "--num-envs", "4"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    served = json.loads(done.stdout)["tasks"][0]["returns"]
    np.testing.assert_allclose(served, together, rtol=0, atol=0.02)


# --- the learners ---


SHORT = {
    "zoo.imitation": ["--iterations", "2", "--updates", "2", "--envs", "16"],
    "zoo.ppo": ["--steps", "800", "--envs", "16"],
}


@pytest.mark.parametrize(
    ("script", "name"),
    [
        ("zoo.imitation", "mamba"),
        pytest.param("zoo.imitation", "none", marks=pytest.mark.long),
        ("zoo.ppo", "gtrxl"),
    ],
)
def test_a_learner_runs_and_resumes(tmp_path: Path, script: str, name: str) -> None:
    options = [*SHORT[script], "--parameters", "4000", "--out", str(tmp_path)]
    lines = run(script, "--memory", name, "--test", OTHER, *options)
    result = json.loads(lines[-1])
    assert result == json.loads((tmp_path / "result.json").read_text())
    assert (result["memory"], result["env_steps"]) == (name, 800)
    assert abs(result["parameters"] - 4000) < 400 < result["all_parameters"] - 4000
    assert result["cpu_s_per_million_steps"] > 0
    remembers = name != "none"
    assert ("wiped" in result) == remembers
    for rates in (result, result["transfer"][OTHER]):
        assert 0 <= rates["success_once"] <= 1
    policy, _, task = learners.checkpoints.load_policy(tmp_path / "agent.pt")
    assert (policy.kind, policy.memory, task) == (name, remembers, TASK)
    run(script, "--memory", name, *options, "--resume")


def test_a_longer_task_with_other_objects_is_refused() -> None:
    rows, layout = rows_of()
    with pytest.raises(ValueError, match=r"9 objects in RememberColor9-VLA-v0; 3 needed"):
        learners.training.transfer(policy_of("gru", rows, layout), ["RememberColor9-VLA-v0"], 2)


@pytest.mark.long
def test_imitation_learns_to_use_the_memory(tmp_path: Path) -> None:
    """Half of the default training; without memory the policy guesses (0.33)."""
    options = ["--memory", "lru", "--iterations", "6", "--evaluate-every", "6"]
    result = json.loads(run("zoo.imitation", *options, "--out", str(tmp_path))[-1])
    assert result["success_once"] > 0.8
    assert result["wiped"]["success_once"] < 0.6


@pytest.mark.long
def test_ppo_learns_to_use_the_memory(tmp_path: Path) -> None:
    """The default training; without memory the policy guesses (0.33)."""
    lines = run("zoo.ppo", "--evaluate-every", "250", "--out", str(tmp_path))
    result = json.loads(lines[-1])
    assert result["success_once"] > 0.6
    assert result["wiped"]["success_once"] < 0.5


@torch.no_grad()
def test_ppo_draws_an_object_and_an_action_for_it() -> None:
    """Their densities and entropies, from those of the two parts."""
    torch.manual_seed(0)
    weights = torch.tensor([0.0, 2.0, -1.0]).log_softmax(-1).expand(1, 20_000, 3)
    mean = torch.tensor([[-1.0, 0.0], [0.5, 1.0], [9.0, 9.0]]).expand(1, 20_000, 3, 2)
    log_std = torch.tensor([[-2.0, -1.0], [-1.0, -2.0], [-3.0, -3.0]]).expand_as(mean)
    policy = learners.zoo.ppo.ObjectThenAction(learners.policy.Choice(weights, mean, log_std))
    drawn = policy.sample()
    assert drawn.shape == (1, 20_000, 3)
    which = drawn[..., -1].long()
    for i in range(3):
        own = drawn[which == i]
        share = weights[0, 0, i].exp()
        assert abs(len(own) / 20_000 - share) < 0.02
        same_mean = own[:, :2].mean(0) - mean[0, 0, i].clamp(-1.5, 1.5)
        assert same_mean.abs().max() < 0.03
    density, entropy = policy.log_prob(drawn), policy.entropy()
    assert density.shape == entropy.shape == drawn.shape
    same(density[..., -1], weights.gather(-1, which[..., None])[..., 0])
    np.testing.assert_allclose(-density.mean((0, 1)), entropy[0, 0], atol=0.03)


# --- the comparison ---


def test_points_of_several_tasks_are_one_curve() -> None:
    def task(*points: tuple[int, float]) -> dict[str, Any]:
        answers = [
            {"delay": delay, "first_answer": {"rate": rate, "interval": [rate - 0.1, rate + 0.1]}}
            for delay, rate in points
        ]
        return {"forgetting": {"points": answers}}

    delays, rates, low, high = learners.forgetting.curve_of(
        [task((1, 0.9), (50, 0.5)), task((5, 0.8), (50, 0.4))]
    )
    assert (delays, rates) == ([1, 5, 50], [0.9, 0.8, 0.5])
    np.testing.assert_allclose([low, high], [[0.8, 0.7, 0.4], [1.0, 0.9, 0.6]])


def test_a_picture_of_probes(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")

    def still(observation: dict[str, Any]) -> list[list[int]]:
        return [[0, 0, 0, 0, 0, 0, -1]] * len(observation["instruction"])

    probes = tmp_path / "probes"
    engram.probe(still, TASK, obs="objects", probes=["forgetting"], episodes=1, output=probes)
    picture = tmp_path / "curves.png"
    run("forgetting", f"still={probes}", "--out", str(picture))
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_runs_continue_and_become_tables(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(learners.zoo.scores.LONGER, TASK, OTHER)  # a Long one takes long
    short = " ".join([*SHORT["zoo.imitation"], "--parameters", "4000"])
    arguments = ["--ids", TASK, "--memories", "none", "gru", "--learners", "imitation"]
    arguments += ["--seeds", "1", "--out", str(tmp_path), "--jobs", "1", "--pass", short]
    assert learners.zoo.scores.main(arguments) == 0
    results = sorted(tmp_path.glob(f"{TASK}/*/result.json"))
    assert [path.parent.name for path in results] == ["imitation_gru-1", "imitation_none-1"]
    assert (tmp_path / "memories.csv").read_text().startswith("id,learner,seed,")
    text = capsys.readouterr().out
    gru = json.loads(results[0].read_text())
    row = next(line for line in text.splitlines() if line.startswith("| gru | 1 |"))
    for rates in (gru, gru["wiped"], gru["transfer"][OTHER]):
        assert f"{rates['success_once']:.3f} (" in row
    written = [path.stat().st_mtime_ns for path in results]
    assert learners.zoo.scores.main(arguments) == 0  # everything is known
    assert [path.stat().st_mtime_ns for path in results] == written
