"""Ten mistakes; each must be found, in its line, and nothing else."""

from __future__ import annotations

import engram
from engram.typing import RgbObservation

TASK = "RememberColor9-VLA-v0"

engram.make_vec(TASK, num_env=4)  # mistake
engram.make_vec(TASK, obs_mode="pixels")  # mistake
engram.make(TASK, num_envs=4)  # mistake
engram.VectorEnv(TASK, 4, autoreset_mode="sometimes")  # mistake
engram.Env(TASK, reward_mode="shaped")  # mistake

env = engram.make_vec(TASK, 4, obs_mode="rgb")
images = env.reset()[0]["image"]  # mistake
obs: RgbObservation = engram.make_vec(TASK, 4).reset()[0]  # mistake
actions = env.act("greedy")  # mistake
steps = engram.describe(TASK)["horizons"]  # mistake
ids = [task["ID"] for task in engram.list()]  # mistake
