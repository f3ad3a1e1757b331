"""Environment with image observations, beside a batch with the labels."""

import torch
from object_detector import (
    ObjectDetector,
    by_appearance,
    detector_layout,
    downsample,
    robot_features,
)
from training import ObjectsEnv, make_batch, scale_lr


class RgbEnv(ObjectsEnv):
    """The student's rows come from proprio and the base camera's image, by its ObjectDetector.

    Two batches have the same seeds and actions: one renders, the other has the labels.
    """

    def __init__(self, task, num_envs, seed=0, most_steps=None, perturb=None, detector=None):
        super().__init__(task, num_envs, seed, most_steps, perturb)
        self.camera = make_batch(task, num_envs, seed, "rgb", perturb)
        self.objects, self.stored = self.layout, []
        self.detector = detector or ObjectDetector(*self.collect_appearances(seed))
        self.layout = detector_layout(self.objects, self.detector.appearances)
        self.optimiser = torch.optim.Adam(self.detector.groups())

    def collect_appearances(self, seed):
        """Appearances in the task, and a token of each, from episodes of the oracle."""
        tokens = [self.objects.split(super().reset(seed=seed))[1]]
        for _ in range(self.horizon - 1):
            tokens.append(self.objects.split(super().step(self.oracle())[0])[1])
        tokens = torch.stack(tokens)
        pairs = self.objects.pairs(tokens)
        appearances = pairs[pairs >= 0].unique()
        return appearances, torch.stack([tokens[pairs == one][0] for one in appearances])

    def reset(self, seed=None):
        super().reset(seed=seed)
        return self.observe(self.camera.reset(seed=seed)[0])

    def step(self, actions):
        rewards = super().step(actions)[1]
        return self.observe(self.camera.step(actions.numpy())[0]), rewards

    def observe(self, observation):
        picture, agent = downsample(observation["rgb"]), robot_features(observation["proprio"])
        tokens = by_appearance(
            self.objects, self.detector.appearances, self.objects.split(self.truth)[1]
        )
        self.truth = torch.cat([agent, tokens.flatten(1)], -1)
        self.last = (picture, tokens)
        return self.detector.rows(picture, agent, self.layout.place)

    def store(self):
        """Stores the last image and its labels."""
        self.stored.append(self.last)

    def learn(self, updates, lr_scale=1.0, batch=64, most=400):
        """Trains the detector on the latest `most` steps, at a share of its learning rates."""
        del self.stored[:-most]
        scale_lr(self.optimiser, lr_scale)
        for _ in range(updates):
            step = torch.randint(len(self.stored), (batch,)).tolist()
            env = torch.randint(self.num_envs, (batch,)).tolist()
            shown = [torch.stack([self.stored[s][i][e] for s, e in zip(step, env)]) for i in (0, 1)]
            loss = self.detector.loss(*shown, self.layout.place)
            self.optimiser.zero_grad()
            loss.backward()
            self.optimiser.step()
        return loss.item()
