"""Mamba (Gu and Dao 2023): a linear system whose step size, input and output depend on the input.

u = silu(conv(W x)),  step, B, C = functions of u
h[t] = exp(step * A) * h[t-1] + step * B u,  y = (C h + D u) * silu(V x)

A step size near zero skips an input, a large one lets it replace the state. Every channel of u has
a state of its own of a few numbers (S6). A short convolution comes before.
"""

import math

import torch
from torch import nn
from torch.nn import functional

from .base import CausalConvolution, Memory
from .scan import scan


class Mamba(Memory):
    """State: the last inputs of the convolution, and h (N, size, numbers)."""

    numbers = 16  # of the state of a channel

    def __init__(self, width, size):
        super().__init__(width, size)
        self.rank = math.ceil(width / 16)
        self.input = nn.Linear(width, 2 * size, bias=False)
        self.convolution = CausalConvolution(size)
        self.select = nn.Linear(size, self.rank + 2 * self.numbers, bias=False)
        self.step = nn.Linear(self.rank, size)
        rates = torch.arange(1.0, self.numbers + 1).repeat(size, 1)
        self.log_rates = nn.Parameter(rates.log())  # of A, which is negative
        self.skip = nn.Parameter(torch.ones(size))  # D
        self.output = nn.Linear(size, width, bias=False)
        self.spread_step_sizes()

    def spread_step_sizes(self, least=1e-3, most=0.1):
        """Initial step sizes, evenly over their logarithms."""
        nn.init.uniform_(self.step.weight, -(self.rank**-0.5), self.rank**-0.5)
        size = torch.exp(torch.empty(self.size).uniform_(math.log(least), math.log(most)))
        with torch.no_grad():
            self.step.bias.copy_(size + torch.log(-torch.expm1(-size)))  # softplus gives the size

    def initial(self, envs):
        before = self.zeros(envs, self.convolution.steps - 1, self.size)
        return before, self.zeros(envs, self.size, self.numbers)

    def sequence(self, inputs, state):
        before, hidden = state
        values, gate = self.input(inputs).chunk(2, -1)
        values, before = self.convolution(values, before)
        values = functional.silu(values)
        parts = [self.rank, self.numbers, self.numbers]
        step, enter, leave = self.select(values).split(parts, -1)
        step = functional.softplus(self.step(step))
        decay = torch.exp(-step[..., None] * self.log_rates.exp())
        hidden = scan(decay, (step * values)[..., None] * enter[..., None, :], hidden)
        outputs = (hidden @ leave[..., None])[..., 0] + self.skip * values
        return self.output(outputs * functional.silu(gate)), (before, hidden[-1])
