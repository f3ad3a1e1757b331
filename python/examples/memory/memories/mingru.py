"""minGRU (Feng et al. 2024, "Were RNNs all we needed?"): a GRU whose gates see the input alone.

z = sigmoid(W x),  c = g(V x),  h[t] = (1 - z) * h[t-1] + z * c

The recurrence is linear in h, so that a scan computes all steps together. What is kept does not
depend on what is remembered already: with one layer, counting is out of reach.
"""

import torch
from torch import nn

from .base import Memory
from .scan import scan


def positive(values):
    """The paper's g: continuous, rising, and above zero, so that states never cancel out."""
    return torch.where(values >= 0, values + 0.5, values.sigmoid())


class MinGru(Memory):
    """State: h (N, size)."""

    def __init__(self, width, size):
        super().__init__(width, size)
        self.candidate_and_gate = nn.Linear(width, 2 * size, bias=False)
        self.output = nn.Linear(size, width, bias=False)

    def initial(self, envs):
        return (self.zeros(envs, self.size),)

    def sequence(self, inputs, state):
        candidate, gate = self.candidate_and_gate(inputs).chunk(2, -1)
        decay, gate = torch.sigmoid(-gate), torch.sigmoid(gate)
        hidden = scan(decay, gate * positive(candidate), *state)
        return self.output(hidden), (hidden[-1],)
