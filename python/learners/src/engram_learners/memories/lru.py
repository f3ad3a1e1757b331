"""Linear recurrent unit (Orvieto et al. 2023): a linear system with a complex diagonal.

h[t] = lambda * h[t-1] + gamma * B x,  y = Re(C h) + D x,  |lambda| < 1

Every number of the state turns and fades at a rate of its own that is learnt, the same in every
step: nothing is shut out, and everything fades. What is nonlinear comes after the recurrence.
"""

import math

import torch
from torch import nn
from torch.nn import functional

from .base import Memory
from .scan import scan


class LinearRecurrence(nn.Module):
    """lambda = exp(-exp(log_rate) + i exp(log_angle)), so that it stays inside the unit circle.

    At first lambda is spread evenly over a ring: its radius from `near` to `far`, its angle to
    `angle`. gamma scales inputs so that states of slow modes are not larger.
    """

    def __init__(self, width, size, near=0.9, far=0.999, angle=math.pi / 10):
        super().__init__()
        radius = torch.sqrt(near**2 + torch.rand(size) * (far**2 - near**2))
        self.log_rate = nn.Parameter(torch.log(-torch.log(radius)))
        self.log_angle = nn.Parameter(torch.log(angle * torch.rand(size) + 1e-6))
        self.log_gamma = nn.Parameter(0.5 * torch.log1p(-(radius**2)))
        self.into = nn.Parameter(torch.randn(2, size, width) / math.sqrt(2 * width))  # B
        self.out_of = nn.Parameter(torch.randn(2, width, size) / math.sqrt(size))  # C
        self.skip = nn.Parameter(torch.randn(width))  # D

    def eigenvalues(self):
        return torch.exp(torch.complex(-self.log_rate.exp(), self.log_angle.exp()))

    def forward(self, inputs, state):
        """Inputs (T, N, width), state (N, size) complex -> outputs (T, N, width), state."""
        real, imaginary = (inputs @ part.T * self.log_gamma.exp() for part in self.into)
        hidden = scan(self.eigenvalues(), torch.complex(real, imaginary), state)
        real, imaginary = self.out_of
        outputs = hidden.real @ real.T - hidden.imag @ imaginary.T
        return outputs + self.skip * inputs, hidden[-1]


class Lru(Memory):
    """The recurrence and, as in the paper's block, GELU and a gated linear unit.

    State: h (N, size) complex.
    """

    def __init__(self, width, size):
        super().__init__(width, size)
        self.recurrence = LinearRecurrence(width, size)
        self.output = nn.Linear(width, 2 * width)

    def initial(self, envs):
        return (self.zeros(envs, self.size, dtype=torch.complex64),)

    def sequence(self, inputs, state):
        outputs, state = self.recurrence(inputs, *state)
        return functional.glu(self.output(functional.gelu(outputs)), -1), (state,)
