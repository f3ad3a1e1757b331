"""Nine memories of one interface, written from their papers' equations in plain PyTorch.

    memory = make("mamba")
    outputs, state = memory(inputs)            # (T, N, width) -> (T, N, width)
    outputs, state = memory(inputs, state)     # goes on

All have the same width outside, and equally many parameters (`PARAMETERS`) inside. Each is one
layer, as its paper describes it. docs/learning.md compares them.
"""

import bisect

import torch

from .base import Memory
from .gtrxl import Gtrxl
from .lru import Lru
from .mamba import Mamba
from .mingru import MinGru
from .recurrent import Gru, Lstm
from .window import NoMemory, Stack
from .xlstm import Xlstm

__all__ = ["MEMORIES", "PARAMETERS", "WIDTH", "Memory", "make", "parameters", "size_for"]

WIDTH = 64
PARAMETERS = 32_000
MEMORIES = {
    "none": NoMemory,
    "stack4": Stack,
    "gru": Gru,
    "lstm": Lstm,
    "mingru": MinGru,
    "lru": Lru,
    "mamba": Mamba,
    "gtrxl": Gtrxl,
    "xlstm": Xlstm,
}


def parameters(module):
    return sum(part.numel() for part in module.parameters())


def size_for(name, width=WIDTH, budget=PARAMETERS):
    """The size at which a memory has the number of parameters that is nearest to the budget."""
    kind = MEMORIES[name]

    def count(size):
        return parameters(kind(width, size))

    with torch.random.fork_rng(devices=[]):  # so that the search leaves no trace in the weights
        most = kind.multiple
        while count(most) < budget:
            most *= 2
        sizes = range(kind.multiple, most + 1, kind.multiple)
        above = sizes[bisect.bisect_left(sizes, budget, key=count)]
        return min(
            above, max(above - kind.multiple, kind.multiple), key=lambda n: abs(count(n) - budget)
        )


def make(name, width=WIDTH, size=None, budget=PARAMETERS):
    """A memory by its name. size: in place of a budget of parameters."""
    if name not in MEMORIES:
        raise ValueError(f"memory {name!r} given; allowed: {', '.join(MEMORIES)}")
    return MEMORIES[name](width, size or size_for(name, width, budget))
