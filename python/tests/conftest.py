"""What several tests need."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import engram

TASK = "RememberColor3-VLA-v0"  # 25 steps; never ends before
ENDING_TASK = "ShellGameTouch-VLA-v0"  # ends at success


def registered_ids() -> list[str]:
    """The ids of tests/data/registry.csv."""
    table = Path(__file__).parents[2] / "tests" / "data" / "registry.csv"
    return [line.split(";")[0] for line in table.read_text().splitlines()[1:]]


@pytest.fixture
def make():
    """engram.make_vec with few threads; closes what it made."""
    made: list[engram.VectorEnv] = []

    def make_vec(id: str = TASK, num_envs: int = 4, **options: Any) -> engram.VectorEnv:
        options.setdefault("threads", 2)
        env = engram.make_vec(id, num_envs, **options)
        made.append(env)
        return env

    yield make_vec
    for env in made:
        env.close()


def assert_same(first: Any, second: Any, where: str = "") -> None:
    """Nested dicts of arrays and scalars are equal, values and types."""
    if isinstance(first, dict):
        assert isinstance(second, dict), where
        assert list(first) == list(second), where
        for key in first:
            assert_same(first[key], second[key], f"{where}.{key}")
    elif not isinstance(first, np.ndarray):
        assert first == second, where
    else:
        assert first.dtype == second.dtype, where
        assert first.shape == second.shape, where
        np.testing.assert_array_equal(first, second, err_msg=where)


def noisy_oracle(env: engram.VectorEnv, rng: np.random.Generator) -> np.ndarray:
    """The oracle with noise in the rotations, so that environments differ but still succeed."""
    actions = env.act("oracle")
    actions[:, 3:6] += rng.normal(0, 0.02, (env.num_envs, 3)).astype(np.float32)
    return actions
