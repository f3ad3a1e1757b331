"""Scenes that a student sees in pictures, beside a batch that tells what is in them."""

import torch
from eye import Eye, by_look, halved, of_pictures, robot
from play import Objects, make_batch, set_pace


class Pictures(Objects):
    """A student's rows are what its Eye makes of the base camera's picture, and proprio.

    Two batches with the same seeds and actions: one draws, the other tells the truth.
    """

    def __init__(self, task, num_envs, seed=0, most_steps=None, eye=None):
        super().__init__(task, num_envs, seed, most_steps)
        self.camera = make_batch(task, num_envs, seed, "rgb")
        self.objects, self.kept = self.sight, []
        self.eye = eye or Eye(*self.look_around(seed))
        self.sight = of_pictures(self.objects, self.eye.looks)
        self.optimiser = torch.optim.Adam(self.eye.groups())

    def look_around(self, seed):
        """Looks that the task has, and a token of each: from episodes of the oracle."""
        tokens = [self.objects.split(super().reset(seed=seed))[1]]
        for _ in range(self.horizon - 1):
            tokens.append(self.objects.split(super().step(self.oracle())[0])[1])
        tokens = torch.stack(tokens)
        pairs = self.objects.pairs(tokens)
        looks = pairs[pairs >= 0].unique()
        return looks, torch.stack([tokens[pairs == look][0] for look in looks])

    def reset(self, seed=None):
        super().reset(seed=seed)
        return self.see(self.camera.reset(seed=seed)[0])

    def step(self, actions):
        rewards = super().step(actions)[1]
        return self.see(self.camera.step(actions.numpy())[0]), rewards

    def see(self, observation):
        picture, agent = halved(observation["rgb"]), robot(observation["proprio"])
        tokens = by_look(self.objects, self.eye.looks, self.objects.split(self.truth)[1])
        self.truth = torch.cat([agent, tokens.flatten(1)], -1)
        self.last = (picture, tokens)
        return self.eye.rows(picture, agent, self.sight.place)

    def keep(self):
        """Keeps the last picture, and what is in it."""
        self.kept.append(self.last)

    def learn(self, updates, pace=1.0, batch=64, keep=400):
        """pace: of the usual learning rates. keep: steps learnt from, the latest ones."""
        del self.kept[:-keep]
        set_pace(self.optimiser, pace)
        for _ in range(updates):
            step = torch.randint(len(self.kept), (batch,)).tolist()
            env = torch.randint(self.num_envs, (batch,)).tolist()
            shown = [torch.stack([self.kept[s][i][e] for s, e in zip(step, env)]) for i in (0, 1)]
            loss = self.eye.loss(*shown, self.sight.place)
            self.optimiser.zero_grad()
            loss.backward()
            self.optimiser.step()
        return loss.item()
