"""Long episodes: a curriculum over delays, and chunks for truncated backpropagation."""

import math

import torch

import engram
from engram_learners.memory_loss import MemoryLoss
from engram_learners.policy import MemoryState
from engram_learners.training import decided, make_batch, selected

SHORT = 5  # ranges up to here need no curriculum
CHANGE = 0.01  # least change of an object in a chunk that is no waiting, 5 mm
ENOUGH = 0.97  # share of the oracle's episodes whose success ends its play
SPARE = 1.15  # steps of the student's episodes, as a multiple of the oracle's
WAITING = 0.25  # share of the chunks of mere waiting that are trained on


class Delays:
    """The ranges that a task's constants have for its delays and counts, from short to its own."""

    def __init__(self, task, options=None):
        """options: of the environment, from env_options.py."""
        self.options = options or {}
        constants = engram.describe(task, obs_mode="objects", **self.options)["changeable"]
        self.own = {
            one["name"]: tuple(one["value"])
            for one in constants
            if one["kind"] == "integer range" and one["value"][1] > SHORT
        }
        self.least = SHORT
        while not self.possible(task):
            self.least *= 2

    def possible(self, task):
        """Whether the task allows delays of `least`."""
        given = {"constants": self.widest(), "options": self.options}
        try:
            make_batch(task, 1, 0, "objects", **given).close()
        except engram.InvalidArgumentError:
            return False
        return True

    def widest(self):
        """Constants of a batch that can be narrowed to all of the curriculum."""
        return {name: (min(low, self.least), high) for name, (low, high) in self.own.items()}

    def at(self, share):
        """Constants of a share of the curriculum; of 1, the task's own."""
        if share >= 1:
            return dict(self.own)
        return {
            name: (min(low, self.least), max(min(self.least, high), int(share * high)))
            for name, (low, high) in self.own.items()
        }

    def narrow(self, env, share, multiple):
        """Narrows the delays, and makes episodes as long as the oracle needs, and some more.

        -> rows of the oracle's episodes (T, N, D).
        """
        most = env.batch.description["horizon"]
        env.narrow(self.at(share), most)
        rows = [env.reset()]
        while len(rows) < most and env.infos["success_once"].mean() < ENOUGH:
            rows.append(env.step(env.oracle())[0])
        steps = math.ceil(SPARE * len(rows) / multiple) * multiple
        env.narrow(self.at(share), min(steps, most // multiple * multiple))
        return torch.stack(rows)


def share_of_delays(progress, first=0.05, full=0.6):
    """The curriculum's share at a training's progress from 0 to 1: a geometric series."""
    return first ** max(0.0, 1 - progress / full)


class Chunks:
    """Cuts collected episodes into chunks, each with the memory's state at its begin."""

    def __init__(self, policy, length):
        self.policy, self.length, self.begins = policy, length, []

    def begin(self, env, played, state):
        """Stores the state before a step in which a chunk begins.

        played: environments of the state. -> those that are not yet decided, and their state.
        """
        if state is not None:
            still = ~decided(env.infos)[played]
            played, state = played[still], selected(self.policy, state, still)
        if len(played):
            self.begins.append((played, state))
        return played, state

    def cut(self, rows, actions):
        """-> rows, actions, labels, and what else `losses_of` gets, each (L or 1, chunks, ...).

        States are those of collecting: gradients end where the chunk begins. Of the chunks in which
        no object changes and the oracle waits, only a share is kept.
        """
        labels = MemoryLoss.labels(self.policy, rows)
        ever = labels[0][-1:]
        chunks = []
        for k, (played, state) in enumerate(self.begins):
            steps = slice(k * self.length, (k + 1) * self.length)
            parts = [part[steps, played] for part in (rows, actions, *labels)]
            parts += [ever[:, played], *pack(self.policy, state, len(played))]
            tokens = parts[0][..., self.policy.layout.agent :]
            busy = (tokens - tokens[:1]).abs().amax((0, 2)) > CHANGE
            busy |= (parts[1][..., :-1].nan_to_num() != 0).any(0).any(-1)
            kept = busy | (torch.rand(len(busy)) < WAITING)
            chunks.append([part[:, kept] for part in parts])
        self.begins = []
        return [torch.cat(parts, 1) for parts in zip(*chunks)]


def pack(policy, state, num_envs):
    """A state with tensors (1, N, ...), by environment. None: at an episode's begin."""
    tokens = policy.layout.tokens
    if not policy.memory:
        return ()
    if state is None:
        return MemoryState(
            torch.full((1, num_envs, tokens), -1),
            torch.zeros(1, num_envs, policy.gru.hidden_size),
            torch.zeros(1, num_envs, tokens, policy.slots.hidden_size),
            torch.zeros(1, num_envs, tokens, policy.kept_size),
        )
    bodies, hidden, slots, exact = state
    slots = slots.unflatten(1, (num_envs, tokens))
    return MemoryState(bodies[None], hidden, slots, exact[None])


def unpack(bodies, hidden, slots, exact):
    return MemoryState(bodies[0], hidden, slots.flatten(1, 2), exact[0])
