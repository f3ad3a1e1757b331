"""A policy that sees objects and may remember: networks, and how observations are cut up.

Observations are those of ``obs_mode="objects"``: the robot, then a token for every object. Sequences
are (T, N, ...) and start at an episode's beginning.
"""

import math

import torch
from torch import nn

TOKEN = "object_"


class Sight:
    """Where things lie in a row of the objects observation, by the description of a batch."""

    def __init__(self, description):
        fields = description["state_fields"]
        self.agent = sum(f["width"] for f in fields if not f["name"].startswith(TOKEN))
        first = [f for f in fields if f["name"].startswith(f"{TOKEN}0_")]
        self.width = sum(f["width"] for f in first)
        self.tokens = sum(f["name"].endswith("_seen") for f in fields)
        begin = first[0]["offset"]
        self.part = {
            f["name"].removeprefix(f"{TOKEN}0_"): slice(
                f["offset"] - begin, f["offset"] - begin + f["width"]
            )
            for f in first
        }
        place = {f["name"]: slice(f["offset"], f["offset"] + f["width"]) for f in fields}
        self.tcp = slice(place["tcp_pose"].start, place["tcp_pose"].start + 3)
        looks = [self.part[name] for name in ("color", "shape", "state", "kind")]
        self.look = slice(looks[0].start, looks[-1].stop)

    def split(self, rows):
        """Rows (..., D) -> robot (..., agent), tokens (..., tokens, width)."""
        tokens = rows[..., self.agent :].unflatten(-1, (self.tokens, self.width))
        return rows[..., : self.agent], tokens


def mlp(*sizes, gain=1.0):
    layers = []
    for i, (a, b) in enumerate(zip(sizes, sizes[1:])):
        last = i == len(sizes) - 2
        linear = nn.Linear(a, b)
        nn.init.orthogonal_(linear.weight, gain if last else math.sqrt(2.0))
        nn.init.zeros_(linear.bias)
        layers += [linear] if last else [linear, nn.Tanh()]
    return nn.Sequential(*layers)


class Policy(nn.Module):
    """Tokens are read one by one and summed; the sum feeds a GRU; the hand acts on the robot, the
    memory, and the object that attention picks out.

    Attention compares what the memory says of the cue (its looks and its place) with every object
    that is seen, and asks a learned question besides. Without memory it has the question alone.

    The memory is trained to tell the cue: what the first observation of the episode showed.
    """

    def __init__(self, sight, memory=True, hidden=64, width=64, token=32, actions=7):
        super().__init__()
        self.sight, self.memory, self.hidden = sight, memory, hidden
        self.looks = sight.look.stop - sight.look.start
        self.place = sight.part["position"]
        self.register_buffer("mean", torch.zeros(sight.agent))
        self.register_buffer("std", torch.ones(sight.agent))
        self.read = mlp(sight.width + 3, token, token)
        self.key = nn.Linear(token, token)
        self.place_gain = nn.Parameter(torch.tensor(1.0))
        self.look_gain = nn.Parameter(torch.full((self.looks,), 1.0))
        known = sight.agent + token
        if memory:
            # What is seen enters the memory as it is, too: learning to keep it is then quick.
            self.encode = mlp(known + self.looks + 3, hidden)
            self.gru = nn.GRU(hidden, hidden)
            self.recall = nn.Linear(hidden, self.looks + 3)
        self.question = nn.Linear(hidden if memory else 1, token)
        self.act = mlp(known + 6 + (hidden if memory else 0), width, width, 2 * actions, gain=0.01)

    def fit(self, rows):
        """Takes the scale of the robot's numbers from these."""
        agent = self.sight.split(rows)[0].flatten(0, -2)
        self.mean.copy_(agent.mean(0))
        self.std.copy_(agent.std(0) + 1e-2)

    def forward(self, rows, state=None):
        """-> mean and log deviation (T, N, 7) of the action, what the memory says of the cue
        (T, N, looks + 3), its state, and the whole context (T, N, ...) for a critic."""
        agent, tokens = self.sight.split(rows)
        seen = tokens[..., :1]
        offset = (tokens[..., self.place] - agent[..., None, self.sight.tcp]) * seen
        read = self.read(torch.cat([tokens, 5 * offset], -1)) * seen
        scaled = ((agent - self.mean) / self.std).clamp(-5, 5)
        known = torch.cat([scaled, read.sum(-2)], -1)
        cue, parts = None, [known]
        question = torch.ones_like(agent[..., :1])
        if self.memory:
            plain = [tokens[..., part].sum(-2) for part in (self.sight.look, self.place)]
            entry = torch.tanh(self.encode(torch.cat([known, *plain], -1)))
            question, state = self.gru(entry, state)
            cue = self.recall(question)
            parts.append(question)
        match = (self.key(read) * self.question(question)[..., None, :]).sum(-1)
        if cue is not None:
            match = match + self.likeness(cue, tokens)
        weights = match.masked_fill(seen[..., 0] == 0, -1e4).softmax(-1) * seen[..., 0]
        at = (weights[..., None] * torch.cat([offset, tokens[..., self.place]], -1))
        context = torch.cat([*parts, at.sum(-2) * 5], -1)
        mean, deviation = self.act(context).chunk(2, -1)
        return mean, (deviation - 1.0).clamp(-5.0, 0.0), cue, state, context

    def likeness(self, cue, tokens):
        """How much every object is like what the memory says of the cue."""
        looks = torch.sigmoid(cue[..., None, :-3]) * tokens[..., self.sight.look]
        away = tokens[..., self.place] - cue[..., None, -3:]
        return (4 * self.look_gain * looks).sum(-1) - 40 * self.place_gain * (away**2).sum(-1)


def groups(policy, lr, memory_lr):
    """Parameters for an optimiser: the memory learns faster than the hand."""
    parts = [policy.read]
    if policy.memory:
        parts += [policy.encode, policy.gru, policy.recall]
    fast = {id(p) for part in parts for p in part.parameters()}
    return [
        {"params": [p for p in policy.parameters() if id(p) not in fast], "lr": lr},
        {"params": [p for p in policy.parameters() if id(p) in fast], "lr": memory_lr},
    ]


def shown_first(sight, rows):
    """What the first observation showed, (N, looks + 3): which looks there were, and where, in the
    mean. The label of the memory's training. It is no privilege: the policy has seen it."""
    tokens = sight.split(rows[0])[1]
    seen = tokens[..., :1]
    looks = tokens[..., sight.look].amax(-2)
    place = (tokens[..., sight.part["position"]] * seen).sum(-2) / seen.sum(-2).clamp(min=1)
    return torch.cat([looks, place], -1)


def recall_loss(cue, label):
    """How badly the memory tells the cue, over all steps."""
    label = label.expand(len(cue), -1, -1)
    looks = nn.functional.binary_cross_entropy_with_logits(
        cue[..., :-3], label[..., :-3], reduction="none"
    )
    place = (cue[..., -3:] - label[..., -3:]) ** 2
    return (looks.sum(-1) + 10 * place.sum(-1)).mean()


def can_act(sight, rows):
    """Steps (T, N) in which as much is seen as ever in the episode: where cues are frozen, the
    robot's actions count from there on."""
    seen = sight.split(rows)[1][..., 0].sum(-1)
    return seen >= seen.amax(0)
