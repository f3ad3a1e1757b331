"""The example in the shape of RLinf's environments, which its package does not have by itself."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from example_runs import load

torch = pytest.importorskip("torch")

TASK = "InterceptSlow-VLA-v0"


def made(offset=0, **cfg):
    given = {
        "seed": 3,
        "group_size": 2,
        "auto_reset": True,
        "ignore_terminations": False,
        "use_rel_reward": True,
        "init_params": {"id": TASK, "image_size": 16, "threads": 1},
        **cfg,
    }
    return load("rlinf_env").EngramEnv(SimpleNamespace(**given), 4, offset, 2, None)


def test_groups_begin_alike_and_processes_apart():
    one, other = made(0), made(1)
    seen, infos = one.reset()
    assert seen["main_images"].shape == seen["wrist_images"].shape == (4, 16, 16, 3)
    assert len(seen["task_descriptions"]) == 4
    assert not infos["success"].any()
    images = seen["main_images"]
    assert torch.equal(images[0], images[1])
    assert torch.equal(images[2], images[3])
    assert not torch.equal(images[0], images[2])
    assert not torch.equal(images, other.reset()[0]["main_images"])


@pytest.mark.parametrize("ignored", [False, True])
def test_chunks_end_and_begin_again(ignored):
    env = made(ignore_terminations=ignored)
    env.reset()
    returns, ends = torch.zeros(4), torch.zeros(4, dtype=torch.bool)
    for _ in range(20):
        chunk = torch.stack([torch.from_numpy(env.env.act("oracle"))] * 3, 1)
        seen, rewards, terminated, truncated, infos = env.chunk_step(chunk)
        assert len(seen) == len(infos) == 3
        assert rewards.shape == terminated.shape == truncated.shape == (4, 3)
        assert not (terminated | truncated)[:, :-1].any()
        returns += rewards.sum(1)
        ended = (terminated | truncated)[:, -1]
        ends |= ended
        if ended.any():
            assert torch.equal(infos[-1]["_final_info"], ended)
            final = infos[-1]["final_info"]["episode"]
            assert (final["episode_len"][ended] > infos[-1]["episode"]["episode_len"][ended]).all()
            assert not terminated.any() or not ignored
    assert ends.all()
    assert returns.sum() > 0, "the oracle succeeds"
