"""python/examples: one file each; parts of ppo_lstm.py and distil.py, and that they learn."""

from __future__ import annotations

import ast
import math
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from example_runs import FOLDER, learn, load

torch = pytest.importorskip("torch")

TASK = "RememberColor3-VLA-v0"
LEARNERS = ("ppo", "ppo_lstm", "distil")
LIBRARIES = {"engram", "gymnasium", "matplotlib", "numpy", "torch"}  # matplotlib: ppo.py's curve
SHORT = {
    "ppo_lstm": ("--total-timesteps", "1600", "--num-envs", "16", "--eval-every", "2"),
    "distil": ("--num-iterations", "4", "--num-envs", "8", "--num-updates", "2", "--eval-every=2"),
}


@pytest.fixture(scope="module")
def ppo_lstm() -> ModuleType:
    return load("ppo_lstm")


@pytest.fixture(scope="module")
def distil() -> ModuleType:
    return load("distil")


def agent_of(example: ModuleType, num_envs: int = 4) -> tuple[object, object]:
    """An environment, reset, and an untrained agent."""
    env = example.make_env(SimpleNamespace(id=TASK, seed=3), num_envs)
    env.reset(seed=3)
    torch.manual_seed(0)
    return env, example.Agent(example.Layout(env), env.description["action_dim"], 16)


@pytest.mark.parametrize("name", LEARNERS)
def test_a_learner_is_one_short_file(name: str) -> None:
    text = (FOLDER / f"{name}.py").read_text()
    assert text.count("\n") < 450
    imported = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            imported |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0
            imported.add((node.module or "").split(".")[0])
    assert imported - set(sys.stdlib_module_names) <= LIBRARIES


@pytest.mark.parametrize("name", ["ppo_lstm", "distil"])
def test_the_layout_is_that_of_the_description(name: str) -> None:
    """Columns from `objects_dict` are those that the row of `objects` has."""
    example = load(name)
    env, agent = agent_of(example)
    observation = example.to_tensors(env.reset(seed=3)[0])
    fields = {field["name"]: field for field in env.description["state_fields"]}
    for part, columns in agent.layout.token.items():
        assert columns.stop - columns.start == fields[f"object_0_{part}"]["width"]
    assert observation.robot.shape == (4, agent.layout.robot_width)
    assert observation.tokens.shape[-1] == agent.layout.token_width
    assert (observation.tokens[..., agent.layout.token["seen"]].sum((1, 2)) == 1).all()  # the cue


@pytest.mark.parametrize("name", ["ppo_lstm", "distil"])
def test_steps_one_by_one_equal_the_whole_sequence(name: str) -> None:
    example = load(name)
    env, agent = agent_of(example)
    sequence = []
    for _ in range(25):
        observation = example.to_tensors(env.step(env.act("oracle"))[0])
        sequence.append(observation)
    whole = example.Observation(*(torch.stack(part) for part in zip(*sequence)))
    with torch.no_grad():
        output = agent(whole)
        best = output.policy.best() if name == "ppo_lstm" else output.best()
        state = None
        for t, observation in enumerate(sequence):
            one = agent(example.Observation(*(part[None] for part in observation)), state)
            state = one.lstm_state if name == "ppo_lstm" else one.gru_state
            action = one.policy.best() if name == "ppo_lstm" else one.best()
            np.testing.assert_allclose(action[0], best[t], atol=1e-4)


def test_advantages_equal_their_definition(ppo_lstm: ModuleType) -> None:
    generator = torch.Generator().manual_seed(1)
    rewards = torch.rand(9, 3, generator=generator)
    values = torch.rand(9, 3, generator=generator)
    after = torch.cat([values[1:], torch.zeros(1, 3)])
    errors = rewards + 0.8 * after - values
    expected = [sum((0.56**k) * errors[t + k] for k in range(9 - t)) for t in range(9)]
    advantages = ppo_lstm.estimate_advantages(rewards, values, 0.8, 0.7)
    np.testing.assert_allclose(advantages, torch.stack(expected), rtol=1e-5)


def test_the_probability_of_an_object_and_an_action_is_their_product(ppo_lstm: ModuleType) -> None:
    torch.manual_seed(0)
    logits = torch.tensor([0.0, 2.0, -1.0]).expand(1, 20_000, 3)
    mean = torch.tensor([[-1.0, 0.0], [0.5, 1.0], [9.0, 9.0]]).expand(1, 20_000, 3, 2)
    log_std = torch.tensor([[-2.0, -1.0], [-1.0, -2.0], [-3.0, -3.0]]).expand_as(mean)
    policy = ppo_lstm.ObjectThenAction(logits, mean, log_std)
    drawn = policy.sample()
    index = drawn[..., -1].long()
    assert torch.equal(policy.best()[0, 0], torch.tensor([0.5, 1.0]))
    for i in range(3):
        own = drawn[index == i]
        assert abs(len(own) / 20_000 - float(policy.objects.probs[0, 0, i])) < 0.02
        assert (own[:, :2].mean(0) - mean[0, 0, i]).abs().max() < 0.03
    log_prob, entropy = policy.log_prob(drawn), policy.entropy()
    assert log_prob.shape == entropy.shape == (1, 20_000)
    np.testing.assert_allclose(-log_prob.mean(), entropy[0, 0], atol=0.03)


def test_the_loss_of_the_memory_is_about_the_first_observation(ppo_lstm: ModuleType) -> None:
    env, agent = agent_of(ppo_lstm)
    rollout = ppo_lstm.collect(agent, env, 25)
    appearances = agent.layout.appearances(rollout.observations.tokens)
    assert (appearances[0].sum((-1, -2)) == 2).all()  # a colour and a shape
    assert (appearances[-1].amax(-2).sum(-1) == 4).all()  # three colours, one shape


def test_attention_learns_the_object_of_the_oracle(distil: ModuleType) -> None:
    weights = torch.zeros(2, requires_grad=True)
    actions = torch.stack([torch.zeros(7), torch.ones(7)])[None, None].requires_grad_()
    output = distil.Output(
        weights.log_softmax(-1)[None, None], actions, torch.zeros(1), torch.zeros(1)
    )
    distil.imitation_loss(output, torch.full((1, 1, 7), 0.9)).sum().backward()
    assert weights.grad[1] < -0.01 < 0.01 < weights.grad[0]
    assert actions.grad[0, 0, 1].abs().min() > 1e-2 > 1e-4 > actions.grad[0, 0, 0].abs().max()


def test_the_oracle_guides_the_first_episodes(distil: ModuleType) -> None:
    env, agent = agent_of(distil, 32)
    distil.collect(agent, env, 25, first=True)
    infos = env.step(np.zeros((32, 7), np.float32))[4]  # after the end: nothing moves
    assert infos["success_once"].all()


@pytest.mark.parametrize("name", list(SHORT))
def test_it_runs_and_leaves_its_files(name: str, tmp_path: Path) -> None:
    output, rows = learn(name, tmp_path, *SHORT[name], "--eval-episodes", "8")
    assert "8 fresh episodes" in output
    assert [row["iteration"] for row in rows] == [1, 2, 3, 4]
    assert [math.isnan(row["eval_success_once"]) for row in rows] == [True, False] * 2
    losses = [key for key in rows[0] if "loss" in key]
    assert losses
    assert all(math.isfinite(row[key]) for row in rows for key in losses)
    weights = torch.load(tmp_path / "agent.pt", weights_only=True)
    assert all(torch.isfinite(value).all() for value in weights.values())


@pytest.mark.parametrize("name", list(SHORT))
def test_the_same_seed_learns_the_same(name: str, tmp_path: Path) -> None:
    short = (*SHORT[name], "--eval-episodes", "4")
    logs = [
        learn(name, tmp_path / run, *short, *seed)[1]
        for run, seed in (("one", ()), ("two", ()), ("other", ("--seed", "2")))
    ]
    key = "policy_loss" if name == "ppo_lstm" else "loss"
    one, two, other = ([row[key] for row in log] for log in logs)
    assert one == two != other


@pytest.mark.long
@pytest.mark.parametrize("name", list(SHORT))
def test_it_learns_to_use_the_memory(name: str, tmp_path: Path) -> None:
    """The default training; without memory the policy guesses (0.33)."""
    output, _ = learn(name, tmp_path)
    last = output.splitlines()[-1]
    rates = [float(part.split()[0]) for part in last.replace(",", "").split("success_once ")[1:]]
    assert rates[0] > 0.9
    assert float(last.split("without memory ")[1].split(",")[0]) < 0.5
