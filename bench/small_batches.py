"""Times the steps of one environment from Python, beside the goals for them.

small_batches.py [ROUNDS] [ID], default 9 rounds of RememberColor9-VLA-v0. Random actions, one
thread, whole episodes without their resets. The rows take turns; a row's value is the median of its
rounds, in processor time. "overhead" is the same step without physics, less the library's own call:
what Python adds.
"""

import statistics
import sys
import time
import warnings

import numpy as np

import engram
from engram.envs.env import Env

EPISODES = 20  # of a round
# us; of one core that nothing else works on.
GOALS = {
    "VectorEnv": 12,
    "VectorEnv, views": 12,
    "Env": 14,
    "VectorEnv, overhead": 5,
    "VectorEnv, views, overhead": 4,
    "Env, overhead": 5,
}


def main():
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 9
    task = sys.argv[2] if len(sys.argv) > 2 else "RememberColor9-VLA-v0"
    rows = {}
    for name, make in (
        ("VectorEnv", lambda **more: engram.VectorEnv(task, 1, threads=1, **more)),
        (
            "VectorEnv, views",
            lambda **more: engram.VectorEnv(task, 1, threads=1, copy=False, **more),
        ),
        ("Env", lambda **more: Env(task, **more)),
    ):
        env, bare = make(), make(substeps=0)
        single = isinstance(env, Env)
        rows[name] = (env, env.step, single)
        rows[f"{name}, no physics"] = (bare, bare.step, single)
        batch = bare.batch if single else bare
        rows[f"{name}, library"] = (bare, batch._batch.step, False)
    steps = engram.describe(task)["horizon"] - 1
    actions = np.random.default_rng(0).uniform(-1, 1, (steps, 1, 7)).astype(np.float32)
    values = {name: [] for name in rows}
    for _ in range(rounds):
        for name, (env, step, single) in rows.items():
            values[name].append(time_of(env, step, list(actions[:, 0] if single else actions)))
    medians = {name: statistics.median(times) for name, times in values.items()}
    for name in ("VectorEnv", "VectorEnv, views", "Env"):
        bare = medians.pop(f"{name}, no physics")
        medians[f"{name}, overhead"] = bare - medians.pop(f"{name}, library")
    print(f"{'us per step':28}{'value':>8}{'goal':>8}")
    for name, value in medians.items():
        print(f"{name:28}{value:8.2f}{GOALS[name]:8}")


def time_of(env, step, actions):
    """Microseconds per step."""
    spent = 0
    for episode in range(EPISODES):
        env.reset(seed=episode)
        begin = time.process_time_ns()
        for action in actions:
            step(action)
        spent += time.process_time_ns() - begin
    return spent / 1000 / EPISODES / len(actions)


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    main()
