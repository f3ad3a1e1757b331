"""Outputs in arrays and tensors of the user's."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import engram

COLOR = "RememberColor3-VLA-v0"


def test_steps_write_to_the_users_arrays() -> None:
    out = {
        "rgb": np.zeros((3, 16, 16, 6), np.uint8),
        "proprio": np.zeros((3, 7), np.float32),
        "reward": np.zeros(3, np.float32),
        "success_once": np.zeros(3, np.bool_),
    }
    env = engram.make_vec(COLOR, 3, obs_mode="rgb", image_size=16, out=out)
    plain = engram.make_vec(COLOR, 3, obs_mode="rgb", image_size=16)
    obs, _ = env.reset(seed=0)
    expected, _ = plain.reset(seed=0)
    assert obs["rgb"] is out["rgb"]
    assert obs["proprio"] is out["proprio"]
    assert (out["rgb"] == expected["rgb"]).all()
    for _ in range(70):
        actions = plain.act("oracle")
        obs, reward, *_ = env.step(actions)
        expected, own_reward, *_, info = plain.step(actions)
        assert reward is out["reward"]
        assert (reward == own_reward).all()
        assert (out["rgb"] == expected["rgb"]).all()
        assert (out["proprio"] == expected["proprio"]).all()
        assert (out["success_once"] == info["success_once"]).all()


def test_rows_of_observations() -> None:
    out = {"observation": np.zeros((2, 165), np.float32)}
    with pytest.raises(engram.InvalidArgumentError, match=r"shape \(2, \d+\) without gaps"):
        engram.make_vec(COLOR, 2, obs_mode="objects", out=out)
    width = engram.make_vec(COLOR, 2, obs_mode="objects").observation_space.shape[1]
    out = {"observation": np.zeros((2, width), np.float32)}
    env = engram.make_vec(COLOR, 2, obs_mode="objects", out=out)
    assert env.reset()[0] is out["observation"]
    assert out["observation"].any()


def test_two_sets_take_turns() -> None:
    torch = pytest.importorskip("torch")
    turns = [{"rgb": torch.zeros(2, 16, 16, 6, dtype=torch.uint8)} for _ in range(2)]
    env = engram.make_vec(
        [COLOR, "ShellGameTouch-VLA-v0"], 2, obs_mode="rgb", image_size=16, out=turns
    )
    plain = engram.make_vec([COLOR, "ShellGameTouch-VLA-v0"], 2, obs_mode="rgb", image_size=16)
    obs, _ = env.reset(seed=0)
    plain.reset(seed=0)
    assert obs["rgb"] is turns[0]["rgb"]
    for step in range(1, 8):
        actions = plain.act("random")
        env.step_async(actions)
        shown = turns[(step - 1) % 2]["rgb"].clone()
        expected, *_ = plain.step(actions)
        assert (turns[(step - 1) % 2]["rgb"] == shown).all()  # while the other is written
        obs, *_ = env.step_wait()
        assert obs["rgb"] is turns[step % 2]["rgb"]
        assert (obs["rgb"].numpy() == expected["rgb"]).all()


@pytest.mark.parametrize(
    ("out", "message"),
    [
        ({"rewards": np.zeros(2, np.float32)}, "no output named 'rewards'"),
        ({"reward": np.zeros(3, np.float32)}, r"a writable float32 array of shape \(2,\)"),
        ({"reward": np.zeros(2, np.float64)}, "float64"),
        ({"reward": np.zeros((2, 2), np.float32)[:, 0]}, "without gaps"),
        ({"reward": np.broadcast_to(np.float32(0), 2)}, "writable"),
        ({"reward": [0.0, 0.0]}, "list given"),
        ([{"reward": np.zeros(2, np.float32)}, {}], "the same outputs"),
        ([], "a dict from names to arrays, or a list of them"),
        (3, "a dict from names to arrays, or a list of them"),
        ({"reward": np.zeros((0, 2), np.float32)}, "leading axes of 0 given"),
        (
            {"reward": np.zeros((4, 2), np.float32), "proprio": np.zeros((5, 2, 7), np.float32)},
            "leading axes of 4, 5 given, one needed",
        ),
        (
            {"reward": np.zeros((4, 2), np.float32), "success": np.zeros(2, np.bool_)},
            "a leading axis of 4 needed",
        ),
    ],
)
def test_other_arrays_are_refused(out: object, message: str) -> None:
    with pytest.raises(engram.Error, match=message):
        engram.make_vec(COLOR, 2, out=out)


@pytest.mark.parametrize("count", [1, 2])
def test_arrays_that_share_memory_are_refused(count: int) -> None:
    width = engram.make_vec(COLOR, 2, obs_mode="objects").observation_space.shape[1]
    memory = np.zeros(2 * width * 2, np.float32)
    observation = memory[: 2 * width].reshape(2, width)
    reward = memory[2 * width - 1 : 2 * width + 1]
    if count == 1:
        out: object = {"observation": observation, "reward": reward}
    else:
        out = [{"observation": observation}, {"observation": observation}]
    with pytest.raises(engram.InvalidArgumentError, match="share memory; separate ones needed"):
        engram.make_vec(COLOR, 2, obs_mode="objects", out=out)
    env = engram.make_vec(
        COLOR, 2, obs_mode="objects", out={"observation": observation, "reward": memory[-2:]}
    )
    assert env.reset()[0] is observation


def outputs_of_rollout(turns: int, steps: int, **options: Any) -> tuple[Any, list[Any]]:
    """A batch, and copies of its rewards, proprio and observations after a reset and steps."""
    env = engram.make_vec(COLOR, 3, obs_mode="objects", seed=2, **options)
    obs, info = env.reset()
    seen = [(np.array(obs), np.array(info["proprio"]), np.zeros(3, np.float32))]
    for _ in range(steps):
        obs, reward, *_, info = env.step(env.act("oracle"))
        seen.append((np.array(obs), np.array(info["proprio"]), np.array(reward)))
    return env, seen


@pytest.mark.parametrize("as_list", [False, True])
def test_a_rollout_is_written_in_place(as_list: bool) -> None:
    turns, steps = 16, 40
    width = engram.make_vec(COLOR, 3, obs_mode="objects").observation_space.shape[1]
    store = {
        "observation": np.zeros((turns, 3, width), np.float32),
        "proprio": np.zeros((turns, 3, 7), np.float32),
        "reward": np.zeros((turns, 3), np.float32),
    }
    rows = [{name: array[t] for name, array in store.items()} for t in range(turns)]
    _, seen = outputs_of_rollout(turns, steps)
    outputs_of_rollout(turns, steps, out=rows if as_list else store)
    for step in range(steps + 1 - turns, steps + 1):  # the last of each turn
        observation, proprio, reward = seen[step]
        assert (store["observation"][step % turns] == observation).all()
        assert (store["proprio"][step % turns] == proprio).all()
        assert (store["reward"][step % turns] == reward).all()
