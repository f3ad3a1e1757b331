"""Environment with image observations, of one task or several, beside a batch with the labels."""

import numpy as np
import torch

from engram_learners.images.detector import ObjectDetector, Objects, detector_layout, robot_numbers
from engram_learners.images.vocabulary import sort, used_tokens, vocabulary
from engram_learners.instructions import turns_of
from engram_learners.rotations import direction_of, turned
from engram_learners.training import ObjectsEnv, scale_lr

NOISE = 0.004  # metres: deviation of the labels' positions, as of those of a detector
TURN_NOISE = 0.01  # radians: of the turns of long objects
FRAMES = 2400  # most frames that a detector is trained on; of several tasks twice as many


class Frames:
    """Frames with labels of this step and the step before; a random one goes when it is full."""

    def __init__(self, most):
        self.most, self.parts, self.weights = most, None, None

    def add(self, weights, *parts):
        if self.parts is None:
            self.parts, self.weights = parts, weights
            return
        free = max(0, self.most - len(self.weights))
        where = torch.randperm(len(self.weights))[: max(0, len(weights) - free)]
        for kept, part in zip((*self.parts, self.weights), (*parts, weights)):
            kept[where] = part[free:]
        if free:
            self.parts = [torch.cat([a, b[:free]]) for a, b in zip(self.parts, parts)]
            self.weights = torch.cat([self.weights, weights[:free]])

    def batch(self, count):
        pick = torch.multinomial(self.weights, min(count, len(self.weights)))
        return [part[pick] for part in self.parts]


class RgbEnv(ObjectsEnv):
    """The student's rows come from proprio and both cameras' images, by its ObjectDetector.

    Two batches have the same seeds and actions: one renders, the other has the labels.
    """

    def __init__(self, task, num_envs, seed=0, *given, detector=None, **named):
        """given, named: further arguments of ObjectsEnv."""
        super().__init__(task, num_envs, seed, *given, **named)
        self.camera = self.make_batch("rgb")
        shown = self.oracle_tokens(seed) if self.parts or detector is None else None
        self.detector = detector or ObjectDetector(*vocabulary(self.objects, shown))
        self.used = {
            id: used_tokens(self.objects, self.detector, shown[:, part])
            for id, part in self.parts.items()
        }
        self.layout = detector_layout(self.objects, len(self.detector.tokens))
        self.optimiser = torch.optim.Adam(self.detector.parameters(), 4e-3)
        self.frames, self.first = Frames(FRAMES * (2 if self.parts else 1)), True

    def oracle_tokens(self, seed):
        """Tokens (T, N, tokens, width) of the labels in episodes of the oracle."""
        tokens = [self.objects.split(super().reset(seed=seed))[1]]
        for _ in range(self.horizon - 1):
            tokens.append(self.objects.split(super().step(self.oracle())[0])[1])
        return torch.stack(tokens)

    def columns_of(self, task):
        agent, tokens = self.layout.agent, self.layout.tokens
        of_tokens = agent + torch.arange(tokens * self.layout.width).view(tokens, -1)
        return torch.cat([torch.arange(agent), of_tokens[self.used[task["id"]]].flatten()])

    def reset(self, seed=None):
        super().reset(seed=seed)
        self.found = self.detector.initial(self.num_envs)
        self.shown = Objects(*self.found[:3])
        self.turns = turns_of(self.batch.instructions) if self.layout.turn else None
        return self.observe(self.camera.reset(seed=seed)[0])

    def step(self, actions):
        rewards = super().step(actions)[1]
        return self.observe(self.camera.step(actions.numpy())[0]), rewards

    def observe(self, observation):
        images, proprio = (torch.from_numpy(observation[k]) for k in ("rgb", "proprio"))
        before = self.shown
        self.shown = sort(self.objects, self.detector, self.objects.split(self.truth)[1], before)
        self.last = (images, proprio, self.shown, before)
        self.truth = self.rows_of(proprio, self.noisy(self.shown))
        self.found = self.detector.update(images, proprio, self.found)
        return self.rows_of(proprio, self.found)

    def noisy(self, objects):
        place = objects.place + NOISE * torch.randn_like(objects.place)
        if self.layout.turn is None:
            return objects._replace(place=place)
        wrong = direction_of(TURN_NOISE * torch.randn(objects.known.shape))
        return objects._replace(place=place, turn=turned(objects.turn, wrong))

    def rows_of(self, proprio, objects):
        rows = self.detector.rows(proprio, objects, self.layout, self.turns)
        if self.inputs is None:
            return rows
        robot = robot_numbers(self.layout)
        return self.inputs.of_batch(rows, self.task_numbers(), self.sentences, robot)

    def store(self):
        """Stores some of the last frames; those in which objects appear or vanish count more.

        None of episodes that have ended.
        """
        images, proprio, now, before = self.last
        share = self.frames.most / (1.5 if self.first else 8) / float(self.horizons.sum())
        change = (now.known != before.known).any(-1)
        chosen = torch.rand(len(change)) < torch.where(change, 4 * share, share)
        steps = torch.from_numpy(np.array(self.infos["elapsed_steps"]))
        chosen = (chosen & (steps < self.horizons[:, 0])).nonzero()[:, 0]
        if len(chosen) > 0:
            parts = (part[chosen] for part in (images, proprio, *now, *before))
            self.frames.add(torch.where(change[chosen], 2.0, 1.0), *parts)

    def learn(self, updates, lr_scale=1.0, batch=24):
        """Trains the detector on stored frames, at a share of its learning rate."""
        scale_lr(self.optimiser, lr_scale)
        mean = 0.0
        for _ in range(4 * updates if self.first else updates):
            images, proprio, *labels = self.frames.batch(batch)
            loss = self.detector.loss(images, proprio, Objects(*labels[:3]), Objects(*labels[3:]))
            self.optimiser.zero_grad()
            loss.backward()
            self.optimiser.step()
            mean += 0.02 * (loss.item() - mean)
        self.first = False
        return mean
