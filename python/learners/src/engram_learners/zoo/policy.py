"""Policy on object observations with one of the memories of `memories`, and nothing else.

A plain policy, so that what differs is the memory: the sum of what the visible objects are encoded
to goes into the memory; what comes out chooses an object by attention; the action head computes an
action for every object. There is no auxiliary loss, and no feature that is made for a task.

Sequences are (T, N, ...) and begin where an episode begins.
"""

import argparse
import math
from pathlib import Path

import torch
from torch import nn

from engram_learners import memories
from engram_learners.policy import Choice, PolicyOutput, mlp


class ZooPolicy(nn.Module):
    """Attributes: kind, the name of its memory; memory, whether that remembers anything.

    size: of the memory inside; by default, that of `memories.PARAMETERS` parameters.
    """

    def __init__(self, layout, kind="gru", size=None, width=memories.WIDTH):
        super().__init__()
        self.layout, self.kind, self.memory = layout, kind, kind != "none"
        self.predicts = False
        self.register_buffer("mean", torch.zeros(layout.agent))
        self.register_buffer("std", torch.ones(layout.agent))
        self.read = mlp(layout.width + 1, width, width)
        self.encode = nn.Linear(width, width)
        self.norm = nn.LayerNorm(width)
        self.remember = memories.make(kind, width, size)
        self.norm_remembered = nn.LayerNorm(width)
        self.query = nn.Linear(2 * width, width)
        self.key = nn.Linear(width, width)
        self.context_proj = nn.Linear(2 * width + layout.agent, width)
        self.offset_proj = nn.Linear(3 + len(layout.body), width, bias=False)
        self.act = mlp(width, width, 2 * layout.actions, gain=0.01)

    def fit(self, rows):
        """Sets the normalization of the robot's numbers from these rows."""
        agent = self.layout.split(rows)[0].flatten(0, -2)
        self.mean.copy_(agent.mean(0))
        self.std.copy_(agent.std(0) + 1e-2)

    def forward(self, rows, state=None):
        """Continues from a state; None begins an episode. -> PolicyOutput."""
        layout = self.layout
        agent, tokens = layout.split(rows)
        seen = tokens[..., :1]
        offset = 5 * (tokens[..., layout.place] - agent[..., None, layout.tcp]) * seen
        touched = layout.touched(rows)[..., None].float()
        read = self.read(torch.cat([tokens, touched], -1)) * seen
        scaled = ((agent - self.mean) / self.std).clamp(-5, 5)
        entry = self.norm(self.encode(read.sum(-2)))
        remembered, *state = self.recall(tokens, entry, state)
        known = torch.cat([entry, remembered], -1)
        match = (self.key(read) * self.query(known)[..., None, :]).sum(-1)
        match = match / math.sqrt(read.shape[-1])
        weights = match.masked_fill(seen[..., 0] == 0, -1e4).log_softmax(-1)
        # The action sees neither appearances nor weights: it is the same function for all objects.
        here = torch.cat([offset, tokens[..., layout.body]], -1)
        known = torch.cat([known, scaled], -1)
        hidden = torch.tanh(self.context_proj(known)[..., None, :] + self.offset_proj(here))
        mean, log_std = self.act(hidden).chunk(2, -1)
        # Initial action: toward the chosen object.
        mean = mean + towards(layout, rows)
        attended = (weights.exp()[..., None] * torch.cat([here, read], -1)).sum(-2)
        context = torch.cat([known, attended], -1)
        choice = Choice(weights, mean, (log_std - 1.0).clamp(-5.0, 0.0))
        return PolicyOutput(choice, None, state, context)

    def recall(self, tokens, entry, state):
        """-> what the memory gives; the state: bodies of the last step, and that of the memory."""
        before = None if state is None else tuple(state[1:])
        remembered, after = self.remember(entry, before)
        bodies = self.layout.bodies(tokens[-1], self.layout.pairs(tokens[-1]))
        return self.norm_remembered(remembered), bodies, *after

    def figures(self, cpu_s, steps):
        """Facts of a training: environment steps and processor seconds."""
        return {
            "memory": self.kind,
            "parameters": memories.parameters(self.remember),
            "all_parameters": memories.parameters(self),
            "env_steps": steps,
            "cpu_s_per_million_steps": round(1e6 * cpu_s / steps),
        }

    def reset_state(self, state, which):
        """The state with the memory of some environments (N,) reset to an episode's first step."""
        if state is None:
            return None
        bodies, *memory = state
        return bodies.masked_fill(which[:, None], -1), *self.remember.reset(memory, which)

    @staticmethod
    def join(states):
        """One state of a batch, from states of batches of one."""
        return tuple(torch.cat(parts) for parts in zip(*states))

    @staticmethod
    def split(state):
        """States of batches of one, from that of a batch."""
        return zip(*(part.split(1) for part in state))


def towards(layout, rows):
    """Actions by object (..., tokens, actions) that lead to its top.

    In control modes of joints there are none: which joints lead there is not known.
    """
    if not layout.moves_tool:
        return 0.0
    reach = (5 * layout.to_top(rows)).clamp(-1, 1)
    return nn.functional.pad(reach, (0, layout.actions - 3))


def zoo_parser(description):
    """Options of every learner with one of the memories."""
    parser = argparse.ArgumentParser(description=description.splitlines()[0])
    add = parser.add_argument
    add("--memory", default="gru", choices=list(memories.MEMORIES))
    add("--id", default="RememberColor3-VLA-v0")
    add("--test", nargs="+", default=[], metavar="ID", help="tasks to play unchanged at the end")
    add("--seed", type=int, default=1)
    add("--out", type=Path, help="folder for log.csv, curve.png, agent.pt, result.json")
    add("--resume", action="store_true", help="continue with the agent.pt of --out")
    add("--parameters", type=int, default=memories.PARAMETERS, help="of the memory")
    return parser
