"""A user's first steps with an installed engram.

Prints its time, its processor time, and a fingerprint of what there is to see.
"""

import hashlib
import time

started = time.perf_counter()
import engram  # noqa: E402 - timed, too

digest = hashlib.sha256()
for obs_mode in ("state", "rgb"):
    env = engram.make_vec("RememberShapeAndColor3x2-VLA-v0", num_envs=8, seed=7, obs_mode=obs_mode)
    obs, info = env.reset()
    for _ in range(30):
        obs, reward, terminated, truncated, info = env.step(env.act("oracle"))
        for array in obs.values() if obs_mode == "rgb" else (obs,):
            digest.update(array.tobytes())
        digest.update(reward.tobytes())
    env.close()
print(f"{time.perf_counter() - started:.1f} {time.process_time():.1f} {digest.hexdigest()[:16]}")
