"""Steps a batch of the Debian package, and the task library of another project."""

import engram

env = engram.make_vec("RememberColor3-VLA-v0", num_envs=16)
env.reset()
for _ in range(24):
    env.step(env.act("oracle"))
print("Python:", env.num_envs, "environments stepped")
env.close()
engram.load_tasks("/outside/tasks/build/libtouch_spot.so")
env = engram.make_vec("TouchSpot-VLA-v0", num_envs=16)
env.reset()
env.step(env.act("oracle"))
env.close()
