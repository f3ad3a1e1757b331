"""Arrays cross over to torch and jax without a copy."""

from __future__ import annotations

import numpy as np
import pytest


def test_numpy_takes_views_through_dlpack(make):
    obs, _ = make(copy=False).reset(seed=0)
    again = np.from_dlpack(obs)
    assert np.shares_memory(again, obs)


def test_torch_shares_the_memory(make):
    torch = pytest.importorskip("torch")
    env = make(obs_mode="rgb", copy=False)
    obs, _ = env.reset(seed=0)
    images = torch.from_dlpack(obs["rgb"])
    proprio = torch.from_numpy(obs["proprio"])
    assert images.data_ptr() == obs["rgb"].ctypes.data
    _, reward, terminated, _, _ = env.step(torch.zeros(4, 7))
    assert torch.equal(proprio, torch.tensor(obs["proprio"]))  # it follows the buffer
    assert torch.from_dlpack(reward).dtype == torch.float32
    assert torch.from_dlpack(terminated).dtype == torch.bool
    env.close()
    del env, obs
    assert images.float().std() > 10  # tensors keep the buffer alive


def test_torch_tensors_are_actions(make):
    torch = pytest.importorskip("torch")
    import engram

    env = make()
    env.reset(seed=0)
    env.step(torch.zeros(4, 7))
    env.step(torch.zeros(7, 4, dtype=torch.float64).T)
    with pytest.raises(engram.InvalidArgumentError, match="grad"):
        env.step(torch.zeros(4, 7, requires_grad=True))
    tensor = torch.zeros(4, 7)
    assert env.act("oracle", tensor.numpy()) is not None
    assert tensor.abs().sum() > 0


def test_jax_takes_views(make):
    jax = pytest.importorskip("jax")
    env = make(copy=False)
    obs, _ = env.reset(seed=0)
    array = jax.dlpack.from_dlpack(obs)
    np.testing.assert_array_equal(np.asarray(array), obs)
    env.step(jax.numpy.zeros((4, 7)))
