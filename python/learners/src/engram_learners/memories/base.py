"""What all memories have in common: sequences, states and resets."""

import torch
from torch import nn


class Memory(nn.Module):
    """A sequence module with a state.

    Sequences are (T, N, width), those of N environments side by side. A state is a tuple of tensors
    (N, ...). One call with T steps equals T calls with one, each with the state of the one before.

    width: of inputs and outputs, the same for all memories. size: of what is inside; it is chosen
    so that all have equally many parameters (`memories.make`).
    """

    multiple = 1  # sizes are multiples of this

    def __init__(self, width, size):
        super().__init__()
        self.width, self.size = width, size

    def initial(self, envs):
        """The state in which an episode begins."""
        raise NotImplementedError

    def sequence(self, inputs, state):
        """Steps without a reset: inputs (T, N, width), state -> outputs (T, N, width), state."""
        raise NotImplementedError

    def forward(self, inputs, state=None, begins=None):
        """The state is reset before the first steps of episodes: begins (T, N) marks them."""
        if state is None:
            state = self.initial(inputs.shape[1])
        if begins is None:
            return self.sequence(inputs, state)
        steps = len(inputs)
        cuts = sorted({0, *begins.any(1).nonzero()[:, 0].tolist(), steps})
        outputs = []
        for start, end in zip(cuts, cuts[1:]):
            state = self.reset(state, begins[start])
            part, state = self.sequence(inputs[start:end], state)
            outputs.append(part)
        return torch.cat(outputs), state

    def reset(self, state, which):
        """The state, with that of some environments (N,) as it is when an episode begins."""
        new = self.initial(len(which))
        return tuple(
            torch.where(which.view(-1, *[1] * (old.dim() - 1)), fresh, old)
            for fresh, old in zip(new, state)
        )

    def zeros(self, *shape, dtype=None):
        return next(self.parameters()).new_zeros(shape, dtype=dtype)


def last_steps(inputs, before):
    """Inputs (T, N, D) with those of the steps before (N, S, D) in front; the last S of all."""
    longer = torch.cat([before.transpose(0, 1), inputs])
    return longer, longer[len(longer) - before.shape[1] :].transpose(0, 1)


class CausalConvolution(nn.Module):
    """A convolution over the last steps, of each channel alone. Its state are its last inputs."""

    def __init__(self, channels, steps=4):
        super().__init__()
        self.steps = steps
        self.weight = nn.Parameter((2 * torch.rand(channels, steps) - 1) / steps**0.5)
        self.bias = nn.Parameter((2 * torch.rand(channels) - 1) / steps**0.5)

    def forward(self, inputs, before):
        longer, last = last_steps(inputs, before)
        taps = [longer[k : k + len(inputs)] * self.weight[:, k] for k in range(self.steps)]
        return sum(taps, self.bias), last
