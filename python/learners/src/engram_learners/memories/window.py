"""Policies without a memory, and with the last four observations in place of one."""

import torch
from torch import nn

from .base import Memory, last_steps


class NoMemory(Memory):
    """Two layers of each step alone: the control. Nothing is remembered."""

    def __init__(self, width, size):
        super().__init__(width, size)
        self.layers = nn.Sequential(nn.Linear(width, size), nn.SiLU(), nn.Linear(size, width))

    def initial(self, envs):
        return ()

    def sequence(self, inputs, state):
        return self.layers(inputs), state


class Stack(Memory):
    """Two layers of the last four steps, as game players stack frames. Older steps are gone.

    State: the three steps before this one; zeros before an episode's first.
    """

    steps = 4

    def __init__(self, width, size):
        super().__init__(width, size)
        first = nn.Linear(self.steps * width, size)
        self.layers = nn.Sequential(first, nn.SiLU(), nn.Linear(size, width))

    def initial(self, envs):
        return (self.zeros(envs, self.steps - 1, self.width),)

    def sequence(self, inputs, state):
        longer, last = last_steps(inputs, *state)
        steps = [longer[k : k + len(inputs)] for k in range(self.steps)]
        return self.layers(torch.cat(steps, -1)), (last,)
