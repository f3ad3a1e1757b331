"""Batches for tests of wrappers for training, and what a step of them says."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ENDING_TASK

import engram
from engram.envs.compat import GYMNASIUM_1

N = 6
MODES = ["NEXT_STEP", "SAME_STEP", "DISABLED"] if GYMNASIUM_1 else ["SAME_STEP"]
modes = pytest.mark.parametrize("mode", MODES)


def make(id: str = ENDING_TASK, mode: str = "SAME_STEP", **options) -> engram.VectorEnv:
    options = {"threads": 1, "seed": 3, **options}
    if mode == "DISABLED":
        options["after_end"] = "hold"
    return engram.make_vec(id, N, autoreset_mode=mode, **options)


def values(info: dict, name: str, ended: np.ndarray) -> np.ndarray:
    """An info of the step itself, in the mode SAME_STEP too."""
    result = np.array(info[name])
    for i in np.flatnonzero(ended) if "final_info" in info else []:
        final = info["final_info"]
        result[i] = final[name][i] if isinstance(final, dict) else final[i][name]
    return result


def play(env, steps: int = 45):
    """Steps of the oracle: reward, ended, benchmark's reward, success, elapsed, whether idle."""
    env.reset()
    over = np.zeros(N, bool)
    for _ in range(steps):
        _, reward, terminated, truncated, info = env.step(env.act("oracle"))
        ended = terminated | truncated
        yield (
            reward,
            ended,
            info.get("benchmark_reward", reward),
            values(info, "success", ended),
            values(info, "elapsed_steps", ended),
            over.copy(),
        )
        if env.autoreset_mode.name == "NEXT_STEP":
            over = ended
        elif env.autoreset_mode.name == "DISABLED":
            over = over | ended
