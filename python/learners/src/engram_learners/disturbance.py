"""Training episodes that are disturbed, so that the oracle shows how to go on from there."""

import torch

LATEST = 0.7  # begin of the last disturbances, as a share of the episode
LONGEST = 0.2  # of an episode ...
STEPS = 12  # ... and control steps, at most


class Disturbance:
    """In a share of the episodes, the robot is moved at random for some steps, once.

    Half of these disturbances begin with the episode, so that it goes on from another start; the
    others begin later. While they last, the actions are the same random ones, of a random strength.
    Where a task holds the robot still during its cue, they have no effect.
    """

    def __init__(self, share, horizons, actions):
        """Disturbances of episodes by their steps, (N, 1), and the size of actions."""
        chosen, later, begin, steps, strength = torch.rand(5, *horizons.shape)
        self.begin = (LATEST * horizons * begin * (later < 0.5)).floor()
        most = (LONGEST * horizons).clamp(1, STEPS)
        self.end = torch.where(chosen < share, self.begin + (most * steps).ceil(), -1)
        self.push = strength * (2 * torch.rand(len(horizons), actions) - 1)

    def __call__(self, step, actions):
        """Actions (N, A) of a step, disturbed ones in place of some."""
        return torch.where((self.begin <= step) & (step < self.end), self.push, actions)
