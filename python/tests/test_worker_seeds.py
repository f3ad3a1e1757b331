"""Seeds of environments that are made in different workers, processes and runs."""

from __future__ import annotations

import functools
import multiprocessing
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import gymnasium
import numpy as np
import pytest
from stable_baselines3.common.vec_env import DummyVecEnv, SubprocVecEnv

import engram
from engram import InvalidArgumentError

ID = "RememberColor9-VLA-v0"
WORKERS = 4
ENVS = 32


def _episodes(*batches: engram.VectorEnv) -> np.ndarray:
    """Rows of the first observations, which tell episodes apart."""
    return np.concatenate([batch.reset()[0] for batch in batches])


def _distinct(rows: np.ndarray) -> int:
    return len(np.unique(rows, axis=0))


def _single() -> engram.Env:
    return engram.make(ID)


def test_pairs_of_base_and_worker_play_different_episodes() -> None:
    pairs = [(base, worker) for base in (0, 1) for worker in range(WORKERS)]
    rows = _episodes(*(engram.make_vec(ID, ENVS, seed=pair) for pair in pairs))
    assert _distinct(rows) == len(pairs) * ENVS


def test_a_pair_means_the_documented_number() -> None:
    state = np.random.SeedSequence([7, 3]).generate_state(1, np.uint64)
    assert engram.worker_seed(7, 3) == int(state[0]) // 2
    env = engram.make_vec(ID, 2, seed=(7, 3))
    assert env.seed == engram.worker_seed(7, 3)
    again = engram.make_vec(ID, 2, seed=env.seed)
    np.testing.assert_array_equal(_episodes(env), _episodes(again))


def test_a_pair_survives_the_specification() -> None:
    env = engram.make_vec(ID, 2, seed=(7, 3))
    spec = gymnasium.envs.registration.EnvSpec.from_json(env.spec.to_json())
    again = gymnasium.make_vec(spec, num_envs=2)
    np.testing.assert_array_equal(_episodes(env), again.reset()[0])


def test_unseeded_batches_draw_seeds_and_tell_them() -> None:
    batches = [engram.make_vec(ID, 8) for _ in range(3)]
    assert len({batch.seed for batch in batches}) == 3
    rows = _episodes(*batches)
    assert _distinct(rows) == 24
    again = engram.make_vec(ID, 8, seed=batches[0].seed)
    np.testing.assert_array_equal(rows[:8], _episodes(again))
    single = _single()
    np.testing.assert_array_equal(single.reset()[0], engram.make(ID, seed=single.seed).reset()[0])


def _of_worker(worker: int, make: Callable[[list[Any]], Any]) -> np.ndarray:
    """First observations of 32 single environments; in a process of its own."""
    single = functools.partial(engram.make, ID, threads=1)
    envs = make([single] * ENVS)
    first = envs.reset()
    envs.close()
    return np.asarray(first[0] if isinstance(first, tuple) else first)


@pytest.mark.parametrize("make", [gymnasium.vector.SyncVectorEnv, DummyVecEnv])
def test_unseeded_environments_of_four_processes_play_128_episodes(make: Any) -> None:
    context = multiprocessing.get_context("fork")
    with ProcessPoolExecutor(WORKERS, context) as pool:
        rows = list(pool.map(_of_worker, range(WORKERS), [make] * WORKERS))
    assert _distinct(np.concatenate(rows)) == WORKERS * ENVS


def test_workers_of_gymnasium_play_different_episodes() -> None:
    single = functools.partial(engram.make, ID, threads=1)
    envs = gymnasium.vector.AsyncVectorEnv([single] * 16, context="fork")
    try:
        assert _distinct(envs.reset()[0]) == 16
        assert _distinct(envs.reset(seed=1)[0]) == 16
    finally:
        envs.close()


def test_workers_of_sb3_play_different_episodes() -> None:
    single = functools.partial(engram.make, ID, threads=1)
    envs = SubprocVecEnv([single] * 16, start_method="fork")
    try:
        assert _distinct(np.asarray(envs.reset())) == 16
    finally:
        envs.close()


def test_four_workers_of_torchrl_play_128_episodes() -> None:
    from torchrl.envs import EnvCreator, GymWrapper, ParallelEnv

    def batch(worker: int) -> Any:
        made = engram.make_vec(ID, ENVS, seed=(7, worker), autoreset_mode="DISABLED", threads=1)
        return GymWrapper(made)

    creators = [EnvCreator(functools.partial(batch, worker)) for worker in range(WORKERS)]
    envs = ParallelEnv(WORKERS, creators)
    try:
        rows = envs.reset()["observation"].numpy()
        assert _distinct(rows.reshape(WORKERS * ENVS, -1)) == WORKERS * ENVS
    finally:
        envs.close()


@pytest.mark.parametrize("seeded", [False, True])
def test_four_ranks_of_skrl_play_128_episodes(seeded: bool) -> None:
    """Its wrapper resets with the seed of `set_seed`, by default the same one in all processes."""
    from skrl.envs.wrappers.torch import wrap_env
    from skrl.utils import set_seed

    rows = []
    for rank in range(WORKERS):
        if seeded:
            set_seed(engram.worker_seed(7, rank) % 2**31)
        env = wrap_env(engram.make_vec(ID, ENVS, threads=1), verbose=False)
        rows.append(env.reset()[0].numpy())
    assert _distinct(np.concatenate(rows)) == (WORKERS * ENVS if seeded else ENVS)


def test_without_pairs_workers_share_episodes() -> None:
    """Seeds s + w, as most libraries give them."""
    rows = _episodes(*(engram.make_vec(ID, ENVS, seed=5 + w) for w in range(WORKERS)))
    assert _distinct(rows) == ENVS + WORKERS - 1


@pytest.mark.parametrize("seed", [(1,), (1, 2, 3), (1, -1), (1, 0.5), (2**64, 0)])
def test_other_tuples_are_refused(seed: tuple[float, ...]) -> None:
    with pytest.raises(InvalidArgumentError):
        engram.make_vec(ID, 2, seed=seed)  # type: ignore[arg-type]
