"""Copies stay unchanged however they are held, and their memory is reused afterwards."""

from __future__ import annotations

import gc
import threading
from collections.abc import Iterator

import gymnasium
import numpy as np
import pytest
from conftest import TASK, assert_same

import engram
from engram import _core

MODES = ["state", "state_dict", "rgb", "rgb+depth+segmentation", "objects", "objects_dict"]


def copied(tree):
    if isinstance(tree, dict):
        return {key: copied(part) for key, part in tree.items()}
    return np.array(tree)


def transitions(env, steps: int = 8):
    """(obs, next_obs, reward) as a replay buffer keeps them, beside copies of what they held."""
    obs, _ = env.reset(seed=0)
    kept = []
    for _ in range(steps):
        next_obs, reward, terminated, truncated, info = env.step(env.unwrapped.act("random"))
        results = {"obs": obs, "next": next_obs, "reward": reward, "done": terminated | truncated}
        results["steps"] = info["elapsed_steps"]
        kept.append((results, copied(results)))
        obs = next_obs
    return kept


def first_leaf(tree):
    while isinstance(tree, dict):
        tree = next(iter(tree.values()))
    return tree


@pytest.mark.parametrize("obs_mode", MODES)
def test_transitions_are_not_overwritten(make, obs_mode):
    for results, held in transitions(make(obs_mode=obs_mode)):
        assert_same(results, held)
        assert not np.array_equal(first_leaf(results["obs"]), first_leaf(results["next"]))


def test_so_they_do_through_gymnasium():
    env = gymnasium.make_vec(f"engram/{TASK}", num_envs=2, obs_mode="rgb", threads=1)
    for results, held in transitions(env):
        assert_same(results, held)
    env.close()


def test_final_observations_are_copies_too(make):
    env = make(num_envs=2, obs_mode="rgb", autoreset_mode="SAME_STEP")
    env.reset(seed=0)
    finals = []
    while len(finals) < 2:
        info = env.step(env.act("random"))[4]
        if "final_obs" in info:
            final = info["final_obs"][0]
            finals.append((final, copied(final)))
    for final, held in finals:
        assert_same(final, held)


def test_restore_hands_out_copies(make):
    env = make()
    env.reset(seed=0)
    obs, info = env.restore(env.save())
    kept = copied({"obs": obs, "steps": info["elapsed_steps"]})
    env.step(env.act("random"))
    assert_same({"obs": obs, "steps": info["elapsed_steps"]}, kept)


def test_views_on_request(make):
    env = make(copy=False)
    obs, info = env.reset(seed=0)
    before = obs.copy()
    again, *_, info_after = env.step(env.act("random"))
    assert again is obs
    assert not np.array_equal(obs, before)
    assert info_after["elapsed_steps"] is info["elapsed_steps"]


# --- the memory of large arrays ---


def as_torch(array):
    return pytest.importorskip("torch").from_numpy(array)


def as_torch_by_dlpack(array):
    return pytest.importorskip("torch").from_dlpack(array)


def as_jax(array):
    jax = pytest.importorskip("jax")
    return jax.dlpack.from_dlpack(array)


def as_jax_by_asarray(array):
    return pytest.importorskip("jax").numpy.asarray(array)


HOLDERS = {
    "the array": lambda array: array,
    "a view": lambda array: array[1:, ::2],
    "a view of a view": lambda array: array[1:].reshape(-1)[5:].view(np.uint8)[::-1],
    "a transposed view": lambda array: array.transpose(3, 0, 1, 2),
    "a memoryview": memoryview,
    "a slice of a memoryview": lambda array: memoryview(array).cast("B")[7:],
    "another framework of the buffer": lambda array: np.frombuffer(array, np.uint8),
    "numpy by dlpack": np.from_dlpack,
    "a capsule": lambda array: Capsule(array),
    "torch": as_torch,
    "a view of torch": lambda array: as_torch(array)[1:].permute(0, 3, 1, 2),
    "torch by dlpack": as_torch_by_dlpack,
    "numpy of torch": lambda array: as_torch(array).numpy()[0],
    "jax": as_jax,
    "jax by asarray": as_jax_by_asarray,
}


class Capsule:
    """Holds an unconsumed dlpack capsule."""

    def __init__(self, array):
        self._capsule = array.__dlpack__()

    def __array__(self, dtype=None, copy=None):
        class Once:
            def __init__(self, capsule):
                self.capsule = capsule

            def __dlpack__(self, **_):
                return self.capsule

            def __dlpack_device__(self):
                return (1, 0)

        return np.from_dlpack(Once(self._capsule)).copy()


@pytest.fixture
def frozen() -> Iterator[None]:
    """Spares collections what was there before, such as the modules of torch and jax."""
    gc.freeze()
    yield
    gc.unfreeze()


@pytest.mark.usefixtures("frozen")
@pytest.mark.parametrize("holder", HOLDERS)
def test_referenced_memory_is_never_written_to(holder):
    copies, rng = _core.Copies(), np.random.default_rng(0)
    held = []
    for _ in range(12):
        source = rng.integers(0, 256, (4, 64, 64, 16), np.uint8)
        array = copies.copy(source)
        expected = np.array(HOLDERS[holder](source.copy()))
        held.append((HOLDERS[holder](array), expected))
        del array
        if len(held) > 6:
            del held[0]  # some memory is free all the time
        gc.collect()
        for holding, content in held[:-1]:
            if not isinstance(holding, Capsule):
                np.testing.assert_array_equal(np.asarray(holding), content)
    for holding, content in held:
        np.testing.assert_array_equal(np.asarray(holding), content)


@pytest.mark.parametrize("dtype", [np.uint8, np.bool_, np.int32, np.uint64, np.float32, np.float64])
def test_a_copy_is_an_ordinary_array(dtype):
    source = np.arange(2 * 3 * 50_000).reshape(2, 3, 50_000).astype(dtype)
    source.flags.writeable = False
    copy = _core.Copies().copy(source)
    assert_same(copy, source)
    assert copy.flags.writeable
    assert copy.flags.c_contiguous
    assert copy.ctypes.data % 64 == 0  # jax takes over no other memory


def test_memory_is_used_again():
    copies, source = _core.Copies(), np.zeros(10**6, np.uint8)
    places = set()
    obs = copies.copy(source)
    for _ in range(50):
        next_obs = copies.copy(source)
        places |= {obs.ctypes.data, next_obs.ctypes.data}
        obs = next_obs
    assert len(places) == 2
    assert copies.copy(source[:-1]).shape == (999_999,)  # another size has memory of its own


def test_little_memory_is_retained():
    copies, source = _core.Copies(), np.zeros(10**6, np.uint8)
    many = [copies.copy(source) for _ in range(50)]
    assert copies.spare == 0
    del many
    assert copies.spare == 4 * 10**6


def test_arrays_outlive_the_batch_and_may_die_in_any_thread(make):
    env = make(obs_mode="rgb")
    kept = transitions(env, 6)
    env.close()
    del env
    gc.collect()
    for results, held in kept:
        assert_same(results, held)

    def drop(part):
        part.clear()

    threads = [threading.Thread(target=drop, args=([kept.pop()],)) for _ in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def test_batches_do_not_share_memory_for_copies(make):
    first, second = (make(obs_mode="rgb", seed=seed) for seed in (0, 5))
    obs, _ = first.reset()
    kept = obs["rgb"].copy()
    for _ in range(5):
        second.reset()
    np.testing.assert_array_equal(obs["rgb"], kept)


def test_observations_of_a_loop_take_turns(make):
    env = make(obs_mode="rgb")
    obs, _ = env.reset(seed=0)
    places = set()
    for _ in range(20):
        next_obs, *_ = env.step(env.act("zero"))
        places.add(next_obs["rgb"].ctypes.data)
        obs = next_obs
    assert len(places) <= 2
    assert isinstance(obs["rgb"], np.ndarray)


def test_a_single_environment_hands_out_copies():
    env = engram.make(TASK, obs_mode="rgb")
    obs, _ = env.reset(seed=0)
    kept = copied(obs)
    env.step(env.act())
    assert_same(obs, kept)
    env.close()
