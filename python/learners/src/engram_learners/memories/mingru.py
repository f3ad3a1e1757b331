"""minGRU (Feng et al. 2024, "Were RNNs all we needed?"): a GRU whose gates see the input alone.

z = sigmoid(W x + b),  c = g(V x),  h[t] = (1 - z) * h[t-1] + z * c

The recurrence is linear in h, so that a scan computes all steps together. What is kept does not
depend on what is remembered already: with one layer, counting is out of reach.

b starts spread out, so that at first some numbers of the state fade within a step and some within
fifty. (With zeros, all fade within a few steps, and what a delay asks for was not learnt.)
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
        self.gate_bias = nn.Parameter(torch.linspace(-4.0, 0.0, size))
        self.output = nn.Linear(size, width, bias=False)

    def initial(self, envs):
        return (self.zeros(envs, self.size),)

    def sequence(self, inputs, state):
        candidate, gate = self.candidate_and_gate(inputs).chunk(2, -1)
        gate = gate + self.gate_bias
        decay, gate = torch.sigmoid(-gate), torch.sigmoid(gate)
        hidden = scan(decay, gate * positive(candidate), *state)
        return self.output(hidden), (hidden[-1],)
