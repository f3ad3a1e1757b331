"""engram_learners: the curriculum over delays, chunks of long episodes, warm starts."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from programs import learners, run, torch

import engram

pytest.importorskip("matplotlib")

COLOR3 = "RememberColor3-Long-VLA-v0"
COLOR5 = "RememberColor5-Long-VLA-v0"  # the cue's length is fixed
CUPS = "ShellGameShuffleTouch-Long-VLA-v0"


def untrained(env: Any) -> Any:
    torch.manual_seed(0)
    policy = learners.policy.Policy(env.layout)
    policy.fit(env.reset(seed=3))
    return policy


# --- curriculum ---


@pytest.mark.parametrize("task", [COLOR3, COLOR5, CUPS])
def test_delays_grow_from_short_to_the_tasks_own(task: str) -> None:
    delays = learners.long_episodes.Delays(task)
    constants = {one["name"]: one["value"] for one in engram.describe(task)["changeable"]}
    assert "CUE_PHASE_STEPS" in delays.own
    assert delays.at(1.0) == {name: tuple(constants[name]) for name in delays.own}
    shares = (0.0, 0.05, 0.3, 0.7, 1.0)
    longest = [[high for _, high in delays.at(share).values()] for share in shares]
    assert longest == sorted(longest)
    assert sum(longest[0]) < sum(longest[-1]) / 4
    batch = engram.make_vec(task, num_envs=2, constants=delays.widest())
    for share in shares:  # none is refused
        batch.reset(options={"constants": delays.at(share)})


def test_ranges_that_are_short_stay() -> None:
    assert learners.long_episodes.Delays("SeqOfColors3-VLA-v0").own == {}


def test_the_curriculum_ends_with_whole_delays() -> None:
    share = learners.long_episodes.share_of_delays
    assert share(0.0) == pytest.approx(0.05)
    assert share(0.3) == pytest.approx(0.05**0.5)
    assert share(0.7) == share(1.0) == 1.0


def test_narrowed_episodes_are_as_long_as_the_oracle_needs() -> None:
    delays = learners.long_episodes.Delays(COLOR3)
    env = learners.training.ObjectsEnv(COLOR3, 8, 3, constants=delays.widest())
    rows = delays.narrow(env, 0.05, 30)
    assert len(rows) <= env.horizon <= 60
    assert env.horizon % 30 == 0
    env.reset()
    for _ in range(env.horizon):
        env.step(env.oracle())
    assert env.infos["success_once"].all()
    delays.narrow(env, 1.0, 30)
    assert 200 < env.horizon <= 600


# --- chunks ---


@pytest.fixture(scope="module")
def collected() -> tuple[Any, ...]:
    """Scenes of cups, a policy, the oracle's rows and actions, and the states of collecting."""
    env = learners.training.ObjectsEnv(CUPS, 4, 3, 120)
    policy = untrained(env)
    chunks = learners.long_episodes.Chunks(policy, 40)
    rows, actions = learners.distil.collect(policy, env, first=True, chunks=chunks)
    return policy, rows, actions, list(chunks.begins)


def cut(collected: tuple[Any, ...]) -> Any:
    policy, rows, actions, begins = collected
    chunks = learners.long_episodes.Chunks(policy, 40)
    chunks.begins = list(begins)
    return chunks.cut(rows, actions)


def test_chunks_continue_the_episode(
    collected: tuple[Any, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """From its stored state, a chunk gives what the whole episode gives."""
    monkeypatch.setattr(learners.long_episodes, "WAITING", 1.0)
    policy, rows, actions, _ = collected
    own_rows, own_actions, *others = cut(collected)
    labels, ever, state = others[:3], others[3], others[4:]
    assert own_rows.shape[:2] == (40, 3 * 4)
    assert torch.equal(torch.cat(own_rows.split(4, 1)), rows)
    assert torch.equal(torch.cat(own_actions.split(4, 1)), actions)
    expected = learners.memory_loss.MemoryLoss.labels(policy, rows)
    for part, whole in zip(labels, expected):
        assert torch.equal(torch.cat(part.split(4, 1)), whole)
    assert torch.equal(ever, expected[0][-1:].repeat(1, 3, 1, 1))
    with torch.no_grad():
        whole = policy(rows)[0]
        choice = policy(own_rows, learners.long_episodes.unpack(*state))[0]
    for part, all_of_it in zip(choice, whole):
        np.testing.assert_allclose(torch.cat(part.split(4, 1)), all_of_it, atol=1e-4)


def test_one_chunk_has_the_loss_of_a_whole_episode(collected: tuple[Any, ...]) -> None:
    policy, rows, actions, _ = collected
    chunks = learners.long_episodes.Chunks(policy, len(rows))
    chunks.begins = [(torch.arange(rows.shape[1]), None)]
    labels = learners.memory_loss.MemoryLoss.labels(policy, rows)
    with torch.no_grad():
        whole = learners.distil.losses_of(policy, rows, actions, *labels)
        one = learners.distil.losses_of(policy, *chunks.cut(rows, actions))
    np.testing.assert_allclose(one, whole, rtol=1e-5)


def test_chunks_of_waiting_are_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(learners.long_episodes, "WAITING", 0.0)
    env = learners.training.ObjectsEnv(COLOR3, 16, 3, 300)
    policy = untrained(env)
    chunks = learners.long_episodes.Chunks(policy, 20)
    rows, actions = learners.distil.collect(policy, env, first=True, chunks=chunks)
    begins = list(chunks.begins)
    kept, own_actions, *_ = chunks.cut(rows, actions)
    assert 16 <= kept.shape[1] < sum(len(played) for played, _ in begins) / 3
    moves = sum(
        (actions[20 * k : 20 * k + 20, p, :-1] != 0).any(-1).sum()
        for k, (p, _) in enumerate(begins)
    )
    assert (own_actions[..., :-1] != 0).any(-1).sum() == moves > 0
    seen = kept[..., policy.layout.agent :].unflatten(-1, (3, -1))[..., 0].sum(-1)
    assert ((seen[0] == 1) & (seen[-1] == 0)).any()  # the cue's end


def test_decided_episodes_have_no_more_chunks() -> None:
    env = learners.training.ObjectsEnv(COLOR3, 16, 3, 600)
    policy = untrained(env)
    chunks = learners.long_episodes.Chunks(policy, 20)
    rows, _ = learners.distil.collect(policy, env, first=True, chunks=chunks)
    counts = [len(played) for played, _ in chunks.begins]
    assert counts == sorted(counts, reverse=True)
    assert counts[0] == 16 > counts[-1] > 0
    assert len(rows) == 20 * len(counts) < 600


# --- evaluation, warm starts ---


class Fickle(torch.nn.Module):
    """Plays the oracle's actions, and notes for how many episodes it was asked."""

    predicts = memory = True

    def __init__(self, policy: Any, env: Any) -> None:
        super().__init__()
        self.policy, self.layout, self.env, self.asked = policy, policy.layout, env, []
        self.split, self.reset_state = policy.split, policy.reset_state

    def join(self, states: Any) -> Any:
        return self.policy.join(states)

    def forward(self, rows: Any, state: Any) -> Any:
        _, _, state, _ = self.policy(rows, state)
        which = [int((self.env.truth == row).all(-1).nonzero()[0]) for row in rows[0]]
        self.asked.append(len(which))
        actions = self.env.oracle()[which]
        return SimpleNamespace(best=lambda: actions[None]), None, state, None


def test_decided_episodes_are_not_computed() -> None:
    env = learners.training.ObjectsEnv(COLOR3, 12, 3)
    player = Fickle(untrained(env), env)
    rates = learners.training.evaluate(player, env, 3)
    assert rates == {"success_once": 1.0, "first_answer_correct": 1.0}
    assert player.asked[0] == 12
    assert 0 < player.asked[-1] < 12
    assert len(player.asked) < 600


def test_new_appearances_get_places_of_others() -> None:
    env = learners.training.ObjectsEnv("RememberShape5-VLA-v0", 32, 3)
    policy = untrained(env)
    color = learners.training.ObjectsEnv("RememberColor3-VLA-v0", 32, 3)
    rows, policy.layout = color.reset(seed=3), color.layout
    old = policy.vocabulary.clone()
    pairs = color.layout.pairs(color.layout.split(rows)[1]).unique()
    assert (pairs >= 0).sum() == 3
    policy.replace_appearances(rows)
    kept = policy.vocabulary == old
    assert (~kept).sum() == 3 - torch.isin(pairs, old).sum()
    assert torch.isin(pairs[pairs >= 0], policy.vocabulary).all()
    assert (old[~kept] >= 0).all()  # there is no need of free places
    again = policy.vocabulary.clone()
    policy.replace_appearances(rows)
    assert torch.equal(policy.vocabulary, again)


def test_a_long_task_begins_with_the_policy_of_a_short_one(tmp_path: Path) -> None:
    env = learners.training.ObjectsEnv("RememberColor3-VLA-v0", 4)
    policy = untrained(env)
    learners.checkpoints.save_policy(policy, tmp_path / "agent.pt", "RememberColor3-VLA-v0")
    warm, _, task = learners.checkpoints.load_policy(tmp_path / "agent.pt", COLOR5)
    assert task == "RememberColor3-VLA-v0"
    assert (policy.layout.tokens, warm.layout.tokens) == (3, 5)
    delays = learners.long_episodes.Delays(COLOR5)
    env = learners.training.ObjectsEnv(COLOR5, 4, 3, constants=delays.widest())
    args = SimpleNamespace(
        id=COLOR5, chunk=30, iterations=10, updates=2, batch=120, recall=1.0, huber=0.3, disturb=0.0
    )
    collector = learners.distil.Collector(warm, env, args, delays)
    optimiser = torch.optim.Adam(warm.parameters(), 1e-3)
    losses = learners.distil.learn(warm, optimiser, [collector(0, True)], args)
    assert all(np.isfinite(loss) for loss in losses.values())
    shown = {pair for pair in warm.vocabulary.tolist() if pair >= 0}
    assert len(shown) == 5
    assert collector.steps < 4 * 150


def test_whole_episodes_of_another_task_have_their_appearances() -> None:
    few = learners.training.ObjectsEnv("RememberColor3-VLA-v0", 8, 3)
    policy = untrained(few)
    env = learners.training.ObjectsEnv("RememberColor5-VLA-v0", 8, 3)
    policy.layout = env.layout
    learners.distil.Collector(policy, env, SimpleNamespace(chunk=0, disturb=0.0))(0, trained=True)
    assert (policy.vocabulary >= 0).sum() == 5


@pytest.mark.parametrize(
    ("id", "resets"), [("RememberColor3-VLA-v0", 1), ("RotateLenientPos-VLA-v0", 0)]
)
def test_a_wiped_evaluation_counts_how_often_the_memory_was_reset(id: str, resets: int) -> None:
    env = learners.training.ObjectsEnv(id, 8, 3)
    policy = untrained(env)
    assert "resets" not in learners.training.evaluate(policy, env, 3)
    # The cue is there from the first step, which resets nothing; the choices appear once.
    assert learners.training.evaluate(policy, env, 3, forget=True)["resets"] == resets


def test_the_result_names_the_task_of_the_first_policy(tmp_path: Path) -> None:
    few = ("--envs", "8", "--iterations", "1", "--updates", "2", "--evaluate-every", "0")
    tasks = ("RememberColor3-VLA-v0", "RememberColor5-VLA-v0")
    init: tuple[str, ...] = ()
    for task in tasks:
        run("distil", "--id", task, *few, *init, "--out", str(tmp_path / task))
        init = ("--init", str(tmp_path / task / "agent.pt"))
    result = json.loads((tmp_path / tasks[1] / "result.json").read_text())
    assert (result["id"], result["init"]) == (tasks[1], tasks[0])
    assert "wiped" in result
