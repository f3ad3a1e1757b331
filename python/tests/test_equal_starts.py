"""Groups of environments with equal episodes."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ENDING_TASK, TASK

import engram
from engram.wrappers import EqualStarts


def batch(count: int = 6, size: int = 3, id: str = TASK, **options) -> EqualStarts:
    given = {"seed": 5, "threads": 1, "autoreset_mode": "SAME_STEP", **options}
    return EqualStarts(engram.make_vec(id, count, **given), size)


def test_a_group_begins_equally_and_others_do_not():
    env = batch()
    assert env.group.tolist() == [0, 0, 0, 1, 1, 1]
    for seed, expected in ((None, 5), (None, 7), (40, 40), (None, 42)):
        obs, _ = env.reset(seed=seed)
        for i, group in enumerate(env.group):
            single = engram.make(TASK)
            alone, _ = single.reset(seed=expected + int(group))
            np.testing.assert_array_equal(obs[i], alone)
            single.close()
        assert not np.array_equal(obs[0], obs[3])
    env.close()


def test_the_next_episodes_of_a_group_are_equal_too():
    """Whenever they begin: members end at different times."""
    env = batch(count=2, size=2, id=ENDING_TASK)
    obs, _ = env.reset(seed=1)
    starts: list[list[np.ndarray]] = [[obs[0].copy()], [obs[1].copy()]]
    while min(map(len, starts)) < 3:
        actions = env.env.act("oracle")
        actions[1] = 0  # plays to the horizon
        obs, _, terminated, truncated, _ = env.step(actions)
        for i in np.flatnonzero(terminated | truncated):
            starts[i].append(obs[i].copy())
    assert len(starts[0]) > len(starts[1]) == 3
    for first, second in zip(*starts):
        np.testing.assert_array_equal(first, second)
    env.close()


def test_seeds_and_masks_of_a_reset_are_the_batchs_own():
    env = batch()
    plain = engram.make_vec(TASK, 6, seed=5, threads=1, autoreset_mode="SAME_STEP")
    seeds = [3, 1, 4, 1, 5, 9]
    np.testing.assert_array_equal(env.reset(seed=seeds)[0], plain.reset(seed=seeds)[0])
    mask = {"reset_mask": np.array([True, False] * 3)}
    np.testing.assert_array_equal(env.reset(options=mask)[0], plain.reset(options=mask)[0])
    env.close()
    plain.close()


@pytest.mark.parametrize("size", [0, 4, 7])
def test_sizes_divide_the_environments(size):
    with pytest.raises(engram.InvalidArgumentError, match="group_size"):
        batch(size=size)
