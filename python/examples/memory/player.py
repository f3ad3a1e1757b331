"""A trained policy that is asked for actions: by `engram.evaluate`, or over pipes (`serve.py`).

player = Player.load("runs/color3/agent.pt")
engram.evaluate(player, player.task, obs=player.obs, threads=1, num_envs=50)
"""

import numpy as np
import torch
from eye import halved, robot
from play import load_policy


def join(states):
    """One state of a batch, from states of batches of one."""
    return tuple(torch.cat(parts, axis) for parts, axis in zip(zip(*states), (0, 1, 1)))


def split(state):
    """States of batches of one, from that of a batch."""
    before, known, slots = state
    tokens = before.shape[1]
    return zip(before.split(1), known.split(1, 1), slots.split(tokens, 1))


class Player:
    """Keeps the memory of every episode under way, by the place (worker, slot) that it has."""

    def __init__(self, policy, eye=None, task=None):
        torch.set_num_threads(1)
        self.policy, self.eye, self.task = policy.eval(), eye, task
        self.obs = "objects" if eye is None else "rgb"
        self.width = policy.sight.agent + policy.sight.tokens * policy.sight.width
        self.kept = {}
        if policy.memory:
            state = policy(torch.zeros(1, 1, self.width))[2]
            self.blank = policy.wipe(state, torch.tensor([True]))

    @classmethod
    def load(cls, path):
        return cls(*load_policy(path))

    @torch.no_grad()
    def __call__(self, observation):
        """Observation of `engram.evaluate` -> actions (N, 7)."""
        rows = self.rows(observation)
        if not self.policy.memory:
            return self.policy(rows[None])[0].best()[0].numpy()
        places = [(observation["worker"], slot) for slot in observation["slot"]]
        begins = zip(places, observation["first"])
        states = [self.blank if first else self.kept[place] for place, first in begins]
        choice, _, state, _ = self.policy(rows[None], join(states))
        self.kept.update(zip(places, split(state)))
        return choice.best()[0].numpy()

    def rows(self, observation):
        """What the policy reads (N, width)."""
        given = "pictures" if observation.get("rgb") is not None else "numbers"
        if (given == "numbers") != (self.eye is None):
            raise ValueError(f"{given} given, obs {self.obs} needed: it learnt from them")
        if self.eye is not None:
            agent = robot(observation["proprio"])
            return self.eye.rows(halved(observation["rgb"]), agent, self.policy.sight.place)
        rows = torch.from_numpy(np.array(observation["state"], dtype=np.float32))
        if rows.shape[1] != self.width:
            given = f"{rows.shape[1]} numbers given, {self.width} needed"
            raise ValueError(f"{given}: obs objects of {self.task}, or of a task like it")
        return rows
