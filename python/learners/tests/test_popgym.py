"""engram_learners.zoo.popgym: PPO with the memories, on tasks of the released POPGym."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from programs import learners, run, torch

popgym = pytest.importorskip("engram_learners.zoo.popgym")  # it needs the package popgym


def played(episodes: Any, act: Callable[[list[Any]], Any], seed: int = 3) -> tuple[Any, Any]:
    """Rows (T, N, D) and returns (N,) of a player that gets all rows so far."""
    rows, returns, ended = [episodes.reset(seed)], 0, False
    while not ended:
        after, rewards, ended = episodes.step(act(rows))
        rows.append(after)
        returns = returns + rewards
    return torch.stack(rows), returns


def suit(row: Any) -> Any:
    """RepeatPrevious: what is seen comes first."""
    return row[:, :4].argmax(-1)


@pytest.mark.parametrize(("back", "solved"), [(3, True), (4, False)])
def test_rows_show_what_has_to_be_repeated(back: int, solved: bool) -> None:
    """RepeatPreviousEasy asks for the suit that was seen three steps before this one."""
    episodes = popgym.Episodes("RepeatPreviousEasy", 8)
    rows, returns = played(episodes, lambda rows: suit(rows[max(0, len(rows) - 1 - back)]))
    assert rows.shape == (52, 8, episodes.width)
    if solved:
        np.testing.assert_allclose(returns, 1.0, atol=1e-5)
    else:
        assert returns.max() < 0.3
    seen, last_action = rows[..., :4], rows[..., 4:]
    assert torch.equal(seen.sum(-1), torch.ones(52, 8))
    assert not last_action[0].any()
    assert torch.equal(last_action[back + 1 :], seen[: -back - 1])


def test_autoencode_asks_for_suits_in_reverse_order() -> None:
    """52 suits are seen, the last of them in the first row that asks."""
    episodes = popgym.Episodes("AutoencodeEasy", 4)
    watch = episodes.reset(3)[:, :2].argmax(-1)[0].item()

    def act(rows: list[Any]) -> Any:
        asked = sum(row[0, watch].item() == 0 for row in rows)
        seen = rows[: len(rows) - asked + 1]
        return seen[-asked][:, 2:6].argmax(-1)

    rows, returns = played(episodes, act)
    assert rows.shape == (104, 4, 2 + 4 + 4)
    np.testing.assert_allclose(returns, 1.0, atol=1e-5)


def test_seeds_repeat_episodes() -> None:
    def rows(seed: int) -> Any:
        episodes = popgym.Episodes("RepeatPreviousEasy", 3)
        return played(episodes, lambda rows: suit(rows[-1]), seed)[0]

    assert torch.equal(rows(3), rows(3))
    assert not torch.equal(rows(3), rows(4))
    assert torch.equal(rows(3)[:, 1:], rows(4)[:, :-1])  # seeds of environments are consecutive


@torch.no_grad()
def test_densities_of_played_actions_are_those_of_training() -> None:
    """Step by step, with the memory's state, and the whole sequence at once."""
    torch.manual_seed(0)
    episodes = popgym.Episodes("RepeatPreviousEasy", 4)
    agent = popgym.Agent(episodes.width, episodes.actions, "lru", 8)
    rows, actions, before, values, rewards = popgym.play(agent, episodes, seed=1)
    assert rows.shape[:2] == actions.shape == rewards.shape == (51, 4)
    distribution, value, _ = agent(rows)
    torch.testing.assert_close(distribution.log_prob(actions), before, rtol=1e-4, atol=1e-5)
    torch.testing.assert_close(value, values, rtol=1e-4, atol=1e-5)


def test_ppo_learns_to_remember(tmp_path: Path) -> None:
    """A tenth of the default training; without memory the return is that of guessing (-0.5)."""
    options = ["--steps", "40000", "--evaluate-every", "40", "--out", str(tmp_path)]
    result = json.loads(run("zoo.popgym", "--memory", "stack4", *options)[-1])
    assert result == json.loads((tmp_path / "result.json").read_text())
    assert result["mean_return"] > 0.5
    guessed = json.loads(run("zoo.popgym", "--memory", "none", "--steps", "40000")[-1])
    assert -0.7 < guessed["mean_return"] < -0.2


def test_returns_become_a_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["--learners", "popgym", "--ids", "RepeatPreviousEasy", "--memories", "none"]
    arguments += ["--seeds", "1", "2", "--out", str(tmp_path), "--jobs", "1"]
    assert learners.zoo.scores.main([*arguments, "--pass", "--steps 4000 --parameters 4000"]) == 0
    results = [json.loads(p.read_text()) for p in sorted(tmp_path.glob("*/*/result.json"))]
    assert [result["seed"] for result in results] == [1, 2]
    returns = [result["mean_return"] for result in results]
    text = capsys.readouterr().out
    row = next(line for line in text.splitlines() if line.startswith("| none | 2 |"))
    assert row.startswith(f"| none | 2 | {sum(returns) / 2:.3f} | {min(returns):.3f} |")


def test_a_task_that_no_learner_plays_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, task in (("imitation", "AutoencodeEasy"), ("popgym", "RememberColor3-VLA-v0")):
        given = ["--learners", name, "--ids", task, "--out", str(tmp_path / "runs")]
        with pytest.raises(SystemExit) as end:
            learners.zoo.scores.main(given)
        assert end.value.code == 2
        error = capsys.readouterr().err
        allowed = ", ".join(learners.zoo.scores.tasks_of(name))
        assert f"--ids {task} given; tasks of --learners {name}: {allowed}" in error
    assert not (tmp_path / "runs").exists()
