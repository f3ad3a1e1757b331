"""xLSTM (Beck et al. 2024), its block with a matrix memory (mLSTM).

C[t] = f * C[t-1] + i * k v',  n[t] = f * n[t-1] + i * k,  h = q C / max(|q n|, 1)

An associative memory: pairs of keys and values are added to a matrix, and a query reads the values
of keys that are like it. The gates f (sigmoid) and i (exponential) see the input alone, so that
steps are computed together: as attention, in which gates set how much of each earlier step is left,
beside what is left of the state before the sequence.
"""

import torch
from torch import nn
from torch.nn import functional

from .base import CausalConvolution, Memory


class BlockLinear(nn.Module):
    """A linear map of each few channels alone."""

    def __init__(self, channels, block=4):
        super().__init__()
        self.block = block
        weight = torch.randn(channels // block, block, block)
        self.weight = nn.Parameter(weight * (2 / (5 * channels)) ** 0.5)

    def forward(self, inputs):
        blocks = inputs.unflatten(-1, (-1, self.block))
        return torch.einsum("...bi,boi->...bo", blocks, self.weight).flatten(-2)


class MatrixMemory(nn.Module):
    """The cell. State: C (N, heads, d, d) and n (N, heads, d), both times exp(-m); m (N, heads)."""

    def __init__(self, channels, heads):
        super().__init__()
        self.heads = heads
        self.gates = nn.Linear(3 * channels, 2 * heads)  # i, f
        self.scale = nn.Parameter(torch.ones(channels))  # of the norm by head
        nn.init.zeros_(self.gates.weight)
        with torch.no_grad():
            self.gates.bias[:heads].normal_(0, 0.1)
            self.gates.bias[heads:] = torch.linspace(3.0, 6.0, heads)  # f near 1: it remembers

    def forward(self, query, key, value, state):
        """Query, key, value (T, N, channels), state -> outputs (T, N, channels), state."""
        admit, keep = self.gates(torch.cat([query, key, value], -1)).movedim(0, -1).chunk(2, 1)
        kept = functional.logsigmoid(keep).cumsum(-1)  # by all steps so far (N, heads, T)
        query, key, value = (
            part.unflatten(-1, (self.heads, -1)).permute(1, 2, 0, 3)  # (N, heads, T, d)
            for part in (query, key, value)
        )
        key = key / key.shape[-1] ** 0.5
        matrix, norm, offset = state
        # Logarithms of what is left of every step, and of the state, in every step.
        later = torch.ones(kept.shape[-1], kept.shape[-1], dtype=torch.bool).triu(1)
        left = kept[..., :, None] + (admit - kept)[..., None, :]
        left = left.masked_fill(later.to(left.device), -torch.inf)
        old = kept + offset[..., None]
        most = torch.maximum(left.amax(-1), old)
        left, old = torch.exp(left - most[..., None]), torch.exp(old - most)
        match = (query @ key.transpose(-1, -2)) * left
        read = match @ value + old[..., None] * (query @ matrix)
        total = match.sum(-1) + old * (query @ norm[..., None])[..., 0]
        hidden = read / (torch.maximum(total.abs(), torch.exp(-most)) + 1e-6)[..., None]
        outputs = self.normalise(hidden.permute(2, 0, 1, 3))
        left, old = left[..., -1, :, None], old[..., -1, None]
        matrix = old[..., None] * matrix + (left * key).transpose(-1, -2) @ value
        return outputs, (matrix, old * norm + (left * key).sum(-2), most[..., -1])

    def normalise(self, hidden):
        """Each head (T, N, heads, d) has mean 0 and variance 1 -> (T, N, channels)."""
        hidden = functional.layer_norm(hidden, hidden.shape[-1:])
        return hidden.flatten(-2) * self.scale


class Xlstm(Memory):
    """State: the last inputs of the convolution, and that of the cell."""

    heads = 4
    multiple = 4  # of heads, and of blocks of four channels

    def __init__(self, width, size):
        super().__init__(width, size)
        self.input = nn.Linear(width, 2 * size, bias=False)
        self.convolution = CausalConvolution(size)
        self.query, self.key, self.value = (BlockLinear(size) for _ in range(3))
        self.cell = MatrixMemory(size, self.heads)
        self.skip = nn.Parameter(torch.ones(size))
        self.output = nn.Linear(size, width, bias=False)

    def initial(self, envs):
        deep = self.size // self.heads
        before = self.zeros(envs, self.convolution.steps - 1, self.size)
        matrix = self.zeros(envs, self.heads, deep, deep)
        return before, matrix, self.zeros(envs, self.heads, deep), self.zeros(envs, self.heads)

    def sequence(self, inputs, state):
        before, *cell = state
        values, gate = self.input(inputs).chunk(2, -1)
        near, before = self.convolution(values, before)
        near = functional.silu(near)
        query, key, value = self.query(near), self.key(near), self.value(values)
        hidden, cell = self.cell(query, key, value, cell)
        hidden = (hidden + self.skip * near) * functional.silu(gate)
        return self.output(hidden), (before, *cell)
