"""Gated recurrent networks: GRU (Cho et al. 2014) and LSTM (Hochreiter and Schmidhuber 1997).

Each step computes gates from its input and the state before, so that steps cannot be computed
together. Gates that are shut keep the state as it is.
"""

from torch import nn

from .base import Memory


class Recurrent(Memory):
    """A layer of torch's, and a linear map to the outputs. State: one vector, or two (LSTM)."""

    layer: type[nn.RNNBase]
    vectors = 1

    def __init__(self, width, size):
        super().__init__(width, size)
        self.recurrence = self.layer(width, size)
        self.output = nn.Linear(size, width)

    def initial(self, envs):
        return tuple(self.zeros(envs, self.size) for _ in range(self.vectors))

    def sequence(self, inputs, state):
        state = tuple(part[None].contiguous() for part in state)
        outputs, state = self.recurrence(inputs, state if self.vectors > 1 else state[0])
        state = state if self.vectors > 1 else (state,)
        return self.output(outputs), tuple(part[0] for part in state)


class Gru(Recurrent):
    layer = nn.GRU


class Lstm(Recurrent):
    layer = nn.LSTM
    vectors = 2
