"""PPO from objects by a policy that remembers nothing: the control of `ppo_recurrent.py`.

The same observation, the same sight and hand, the same settings; no GRU. What it scores, the task
gives to those who do not remember. (`distil.py --no-memory` is the control of that learner.)

    python memoryless.py --id RememberColor3-VLA-v0 --out runs/memoryless
"""

from ppo_recurrent import main

if __name__ == "__main__":
    main(memory=False)
