"""GTrXL (Parisotto et al. 2019): a transformer with gates, over the last steps.

The layers of Transformer-XL (Dai et al. 2019): attention over this step and those before, by
content and by distance. In place of sums, gates let the result of a layer in; at first nearly shut,
so that an untrained transformer passes its input on. What left the window is forgotten.
"""

import torch
from torch import nn

from .base import Memory


class Gate(nn.Module):
    """A GRU cell whose state is the layer's input. At first it keeps nearly all of it."""

    def __init__(self, channels, keep=2.0):
        super().__init__()
        self.cell = nn.GRUCell(channels, channels)
        with torch.no_grad():
            self.cell.bias_ih[channels : 2 * channels] += keep

    def forward(self, entered, layer):
        """The layer's input and its result, (..., channels) both."""
        shape = entered.shape
        return self.cell(layer.reshape(-1, shape[-1]), entered.reshape(-1, shape[-1])).view(shape)


class RelativeAttention(nn.Module):
    """Attention of each step over itself and up to `window` steps before it.

    Weight of step j in step i: softmax of (q[i] + a) k[j] + (q[i] + b) r[i - j], where r is a
    linear map of sines of the distance, and a and b are learnt.
    """

    def __init__(self, channels, heads, window):
        super().__init__()
        self.heads, self.window, self.deep = heads, window, channels // heads
        self.query = nn.Linear(channels, channels, bias=False)
        self.key_and_value = nn.Linear(channels, 2 * channels, bias=False)
        self.distance = nn.Linear(channels, channels, bias=False)
        self.content_bias = nn.Parameter(torch.zeros(heads, 1, self.deep))  # a
        self.distance_bias = nn.Parameter(torch.zeros(heads, 1, self.deep))  # b
        self.output = nn.Linear(channels, channels, bias=False)
        self.register_buffer("sines", sines(window + 1, channels), persistent=False)

    def forward(self, steps, before, there):
        """Steps (N, T, channels), those before (N, B, channels), and which exist (N, B)."""
        everything = torch.cat([before, steps], 1)
        query = self.by_head(self.query(steps))
        key, value = (self.by_head(part) for part in self.key_and_value(everything).chunk(2, -1))
        far = self.by_head(self.distance(self.sines)[None])
        by_content = (query + self.content_bias) @ key.transpose(-1, -2)
        by_distance = (query + self.distance_bias) @ far.transpose(-1, -2)
        count, all_steps = steps.shape[1], everything.shape[1]
        now = torch.arange(all_steps - count, all_steps, device=steps.device)
        away = now[:, None] - torch.arange(all_steps, device=steps.device)
        index = away.clamp(0, self.window).expand(*by_distance.shape[:2], -1, -1)
        match = (by_content + by_distance.gather(-1, index)) / self.deep**0.5
        exists = torch.cat([there, there.new_ones(len(steps), count)], 1)
        hidden = (away < 0) | (away > self.window) | ~exists[:, None, None]
        weights = match.masked_fill(hidden, -torch.inf).softmax(-1)
        return self.output((weights @ value).transpose(1, 2).flatten(-2))

    def by_head(self, values):
        """(N, T, channels) -> (N, heads, T, deep)."""
        return values.unflatten(-1, (self.heads, self.deep)).transpose(1, 2)


def sines(count, channels):
    """Sines and cosines (count, channels) of distances 0, 1, 2 ..."""
    rates = 10_000 ** (-torch.arange(0, channels, 2) / channels)
    angles = torch.arange(count)[:, None] * rates
    return torch.cat([angles.sin(), angles.cos()], -1)[:, :channels]


class Gtrxl(Memory):
    """State: the block's last inputs (N, window, size), and which of them exist (N, window)."""

    heads, window = 2, 64
    multiple = 2

    def __init__(self, width, size):
        super().__init__(width, size)
        self.input = nn.Linear(width, size)
        self.norm, self.second_norm = nn.LayerNorm(size), nn.LayerNorm(size)
        self.attention = RelativeAttention(size, self.heads, self.window)
        self.gate, self.second_gate = Gate(size), Gate(size)
        self.layers = nn.Sequential(nn.Linear(size, 2 * size), nn.ReLU(), nn.Linear(2 * size, size))
        self.output = nn.Linear(size, width)

    def initial(self, envs):
        exist = self.zeros(envs, self.window, dtype=torch.bool)
        return self.zeros(envs, self.window, self.size), exist

    def sequence(self, inputs, state):
        before, there = state
        steps = self.input(inputs).transpose(0, 1)
        all_steps = torch.cat([before, steps], 1)
        exist = torch.cat([there, there.new_ones(steps.shape[:2])], 1)
        state = all_steps[:, -self.window :], exist[:, -self.window :]
        used = slice(self.window - int(there.sum(1).max()), None)  # the others exist nowhere
        attended = self.attention(self.norm(steps), self.norm(before[:, used]), there[:, used])
        steps = self.gate(steps, attended.relu())
        steps = self.second_gate(steps, self.layers(self.second_norm(steps)).relu())
        return self.output(steps.transpose(0, 1)), state
