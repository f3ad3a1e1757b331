"""Comparison of a client's buffer with engram's steps for the same seed and actions."""

from __future__ import annotations

from typing import Any

import numpy as np

import engram


def assert_transitions(
    id: str,
    *,
    obs: Any,
    actions: Any,
    rewards: Any,
    next_obs: Any = None,
    ended: Any = None,
    seed: int,
    resets: int = 1,
    resets_when_all_end: bool = False,
    **options: Any,
) -> None:
    """Plays the actions again, in a new batch, and compares step by step, bit for bit.

    Args:
        id: The task.
        obs: What the client saw before each step, (steps, environments, ...).
        actions: What it did, (steps, environments, action size).
        rewards: What it got, (steps, environments).
        next_obs: What it saw after each step; at the end of an episode its last observation.
        ended: Where episodes ended.
        seed: Of the first reset.
        resets: How often the client had reset all environments before the first step.
        resets_when_all_end: Whether it resets all once more when all have ended in one step.
        **options: Of the batch; its autoreset_mode is the client's, or SAME_STEP.
    """
    obs, actions, rewards = np.asarray(obs), np.asarray(actions), np.asarray(rewards)
    batch = engram.make_vec(id, obs.shape[1], copy=True, threads=1, **options)
    expected, _ = batch.reset(seed=seed)
    for _ in range(resets - 1):
        expected, _ = batch.reset()
    for step, action in enumerate(actions):
        np.testing.assert_array_equal(obs[step], expected, err_msg=f"obs, step {step}")
        expected, reward, terminated, truncated, info = batch.step(action)
        np.testing.assert_array_equal(rewards[step], reward, err_msg=f"reward, step {step}")
        over = terminated | truncated
        after = expected.copy()
        if "final_obs" in info:
            for i in np.flatnonzero(over):
                after[i] = info["final_obs"][i]
        if next_obs is not None:
            np.testing.assert_array_equal(
                np.asarray(next_obs)[step], after, err_msg=f"next obs, step {step}"
            )
        if ended is not None:
            np.testing.assert_array_equal(np.asarray(ended)[step], over, err_msg=f"step {step}")
        if resets_when_all_end and over.all():
            expected, _ = batch.reset()
    batch.close()


def end_of_episode(env: Any, twin: Any) -> tuple[Any, Any, Any]:
    """Plays the oracle in two batches of one environment until its episode ends.

    Args:
        env: Resets in the step in which the episode ends.
        twin: The same episode, without resets.

    Returns:
        The final observation of the first one, the last observation of the second one, and the
        first one's next observation.
    """
    env.reset(seed=0)
    twin.reset(seed=0)
    while True:
        actions = env.act("oracle")
        obs, _, terminated, truncated, info = env.step(actions)
        last = twin.step(actions)[0]
        if (terminated | truncated).any():
            name = "final_obs" if "final_obs" in info else "final_observation"
            return info[name][0], last, obs
