"""Policy on object observations with an optional memory.

Observations are those of ``obs_mode="objects"``: the robot, then a token for every object.
Sequences are (T, N, ...) and begin where an episode begins.
"""

import math
from typing import Any, NamedTuple

import torch
from torch import nn

from engram_learners.instructions import EMBEDDING, InstructionEncoder
from engram_learners.keyframes import N_CLOCK, N_KEPT, N_SINCE, arrivals, keyframes
from engram_learners.layout import N_GATES, N_GEOMETRY
from engram_learners.paths import N_PATH_BY_OBJECT, N_PATH_GLOBAL, path_size, paths

N_APPEARANCES = 20  # pairs of colour and shape that are distinguished, by default
N_COUNTS = 8  # numbers of changes of a lamp or a button that are distinguished, by default
N_VIEWS = 8  # that are distinguished; later ones count as the last
N_MARKS = 4 + 7  # position encoding on the table: 4 values of x, 7 of y
N_PRIORS = 8  # features of attention priors: seven of the memory, and the tool's distance


def view_code(was_shown):
    """The first view (..., N_VIEWS) of objects that were shown before, about one-hot."""
    views = torch.arange(N_VIEWS, device=was_shown.device)
    away = N_VIEWS * was_shown[..., 2:] - views
    return torch.exp(-((away / 0.5) ** 2)) * was_shown[..., 1:2]


def position_encoding(position):
    """Position encoding (..., N_MARKS) of positions (..., 3) by Gaussians along x and y."""
    x = torch.linspace(-0.5, 0.7, 4, device=position.device)
    y = torch.linspace(-0.6, 0.6, 7, device=position.device)
    distance = torch.cat([position[..., :1] - x, position[..., 1:2] - y], -1)
    return torch.exp(-((distance / 0.2) ** 2))


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
    """Encodes tokens, chooses one by attention, and computes an action for it.

    A GRU integrates the sum of all tokens. A second one, shared by all objects, integrates the part
    of the first one's state that concerns an object, as long as the object can be tracked. Without
    memory there are no GRUs.
    """

    def __init__(
        self,
        layout,
        memory=True,
        appearances=N_APPEARANCES,
        counts=N_COUNTS,
        hidden=64,
        width=64,
        token=32,
        slot=32,
        path_points=0,
    ):
        super().__init__()
        self.appearances, self.counts = appearances, counts
        self.sizes = {
            "appearances": appearances,
            "counts": counts,
            "hidden": hidden,
            "width": width,
        }
        self.keep_paths(path_points if memory else 0)
        n_path_global = N_PATH_GLOBAL if self.path_points else 0
        n_path_by_object = N_PATH_BY_OBJECT if self.path_points else 0
        self.layout, self.memory = layout, memory
        self.predicts = memory  # what has been shown, for the memory's loss
        self.register_buffer("mean", torch.zeros(layout.agent))
        self.register_buffer("std", torch.ones(layout.agent))
        self.register_buffer("vocabulary", torch.full((appearances,), -2))
        self.instruction = InstructionEncoder(len(layout.words)) if layout.words else None
        agent = layout.words_begin + (EMBEDDING if layout.words else 0)
        self.read = mlp(layout.width + 3, token, token)
        seen = agent + token
        memory_size = hidden + slot + N_PRIORS + N_CLOCK + n_path_global if memory else 0
        if memory:
            plain = appearances * (1 + N_MARKS) + len(layout.appearance) + 3
            # Raw inputs beside encoded ones: the memory learns faster to store them.
            self.encode = mlp(agent + plain + 1, hidden)
            self.norm = nn.LayerNorm(hidden)
            self.gru = nn.GRU(hidden, hidden)
            self.global_proj = nn.Linear(hidden, slot)
            self.object_proj = nn.Linear(token + len(layout.appearance) + 3, slot)
            self.shown = nn.Linear(hidden, (3 + N_MARKS) * appearances)
            self.slots = nn.GRU(token + slot + 5 + N_SINCE + appearances, slot)
            self.recall = nn.Linear(slot, appearances + counts + 1)
            # Larger initial outputs speed up learning.
            with torch.no_grad():
                self.shown.weight *= 5
                self.recall.weight *= 3
        # Initial prior: objects that were shown and are not yet touched, or that hide such.
        # Without memory, the nearest object: so the tool does not stop between objects.
        self.prior_gain = nn.Parameter(
            torch.tensor([0.0, 0, 0, 4, 0, 4, 0, 0] if memory else [-8.0])
        )
        self.query = nn.Linear(seen + memory_size, token)
        object_width = token + (slot + N_PRIORS + N_VIEWS if memory else 0)
        self.key = nn.Linear(object_width, token)
        self.context_proj = nn.Linear(seen + memory_size, width)
        by_object = N_GEOMETRY + len(layout.body) + (N_SINCE + 1 if memory else 0)
        by_object += n_path_by_object + n_path_global
        self.offset_proj = nn.Linear(by_object, width, bias=False)
        n = layout.actions
        self.act = mlp(width, width, 2 * n + 2 + N_GATES, gain=0.01)
        with torch.no_grad():
            self.act[-1].bias[-N_GATES:] = torch.tensor([-2.0, 2, 0, 0, 0])  # mostly none
        # Whether to come down can depend on how far the rest of the action is from its goal.
        self.refine = mlp(width + n, width, n, gain=0.01)

    def keep_paths(self, points):
        """Sets how many points of paths the state keeps. No weight depends on their number."""
        self.path_points = self.sizes["path_points"] = points
        self.kept_size = N_KEPT + path_size(points)

    def fit(self, rows):
        """Sets normalization and vocabulary of appearances from these rows."""
        agent, tokens = self.layout.split(rows)
        agent = agent.flatten(0, -2)
        self.mean.copy_(agent.mean(0))
        self.std.copy_(agent.std(0) + 1e-2)
        pairs = self.layout.pairs(tokens).unique()
        pairs = pairs[pairs >= 0][: self.appearances]
        self.vocabulary[: len(pairs)] = pairs

    def replace_appearances(self, rows):
        """Puts new ones of these rows in the vocabulary: in places of others, then in free ones.

        A place's weights are trained, so what the memory does with the old one serves the new one.
        """
        pairs = self.layout.pairs(self.layout.split(rows)[1]).unique()
        new = pairs[(pairs >= 0) & ~torch.isin(pairs, self.vocabulary)]
        others = ~torch.isin(self.vocabulary, pairs)
        order = torch.cat(
            [(others & (self.vocabulary >= 0)).nonzero(), (self.vocabulary < 0).nonzero()]
        )
        places = order[: len(new), 0]
        self.vocabulary[places] = new[: len(places)]

    def colors(self):
        """One-hot colours (appearances, colours) of the vocabulary."""
        color = self.vocabulary.div(self.layout.shapes + 1, rounding_mode="floor")
        return (color[:, None] == torch.arange(self.layout.colors, device=color.device)).float()

    def code(self, pairs):
        """One-hot appearance (..., appearances) of every object, from its pair."""
        return (pairs[..., None] == self.vocabulary).float()

    def forward(self, rows, state=None):
        """Continues from a MemoryState; None begins an episode. -> PolicyOutput."""
        layout = self.layout
        agent, tokens = layout.split(rows)
        seen = tokens[..., :1]
        offset = 5 * (tokens[..., layout.place] - agent[..., None, layout.tcp]) * seen
        read = self.read(torch.cat([tokens, offset], -1)) * seen
        scaled = self.scale(agent)
        priors = distance = offset[..., :2].norm(dim=-1, keepdim=True)
        parts, objects, recalled = [scaled, read.sum(-2)], read, None
        object_features = [layout.geometry(rows), tokens[..., layout.body]]
        if self.memory:
            memory = self.remember(rows, scaled, read, state)
            recalled, state = memory.recalled, memory.state
            priors = self.priors(tokens, memory.was_shown, recalled, distance)
            parts += [memory.hidden, memory.slots.sum(-2), (priors * seen).sum(-2)]
            shown_in = view_code(memory.was_shown)
            objects = torch.cat([read, 4 * priors, memory.slots, shown_in], -1)
            touched = torch.sigmoid(recalled.of_objects[..., -1:].detach())
            object_features += [*memory.object_features, touched]
            parts.extend(memory.global_features)
        features = torch.cat(parts, -1)
        match = (self.key(objects) * self.query(features)[..., None, :]).sum(-1)
        match = match / math.sqrt(read.shape[-1]) + priors @ self.prior_gain
        weights = match.masked_fill(seen[..., 0] == 0, -1e4).log_softmax(-1)
        # The action sees neither appearances nor weights: it is the same function for all objects.
        object_features = torch.cat(object_features, -1)
        context = self.context_proj(features)[..., None, :]
        hidden = torch.tanh(context + self.offset_proj(object_features))
        n = layout.actions
        mean, log_std, planar_motion, gates = self.act(hidden).split([n, n, 2, N_GATES], -1)
        # Initial action: toward the chosen object. (Otherwise the opposite direction is as good.)
        mean = mean + layout.servo(rows, planar_motion, gates)
        mean = mean + self.refine(torch.cat([hidden, mean.clamp(-1, 1)], -1))
        attended = torch.cat([object_features, objects], -1)
        attended = (weights.exp()[..., None] * attended).sum(-2)
        choice = Choice(weights, mean, (log_std - 1.0).clamp(-5.0, 0.0))
        return PolicyOutput(choice, recalled, state, torch.cat([features, attended], -1))

    def scale(self, agent):
        """The robot's numbers, normalised, and the embedding of the instruction."""
        scaled = ((agent - self.mean) / self.std).clamp(-5, 5)
        if self.instruction is None:
            return scaled
        numbers = scaled[..., : self.layout.words_begin]
        words = self.instruction(agent[:1, ..., self.layout.words_begin :])  # the same in all steps
        return torch.cat([numbers, words.expand(*numbers.shape[:-1], -1)], -1)

    def remember(self, rows, scaled, read, state):
        """Integrates a sequence, starting from a MemoryState or None. -> Remembered."""
        layout = self.layout
        tokens = layout.split(rows)[1]
        seen, pairs = tokens[..., :1], layout.pairs(tokens)
        bodies = layout.bodies(tokens, pairs)
        before = MemoryState(None, None, None, None) if state is None else MemoryState(*state)
        new = arrivals(bodies, before.bodies)
        exact = before.exact
        exact = (None, None) if exact is None else (exact[..., :N_KEPT], exact[..., N_KEPT:])
        events = keyframes(layout, rows, new, exact[0])
        path = self.follow_paths(rows, exact[1])
        code = self.code(pairs)
        plain = torch.cat([tokens[..., layout.appearance], tokens[..., layout.place]], -1)
        marks = position_encoding(tokens[..., layout.place])
        bound = torch.einsum("tnkp,tnkc->tnpc", marks, code).flatten(-2)
        entry = torch.cat([scaled, 3 * code.sum(-2), 3 * bound, plain.sum(-2), new], -1)
        hidden, gru_state = self.gru(self.norm(self.encode(entry)), before.hidden)
        shown = self.shown(hidden).unflatten(-1, (3 + N_MARKS, self.appearances))
        hidden = hidden.detach()
        predecessor = torch.einsum("tnpc,tnkp->tnkc", shown[..., 3:, :], marks)
        gated = self.global_proj(hidden)[..., None, :] * self.object_proj(
            torch.cat([read, plain], -1)
        )
        gated = torch.cat([gated, torch.sigmoid(predecessor.detach())], -1)
        shown_at = torch.sigmoid(shown[..., :3, :].detach())
        was_shown = torch.einsum("tnvc,tnkc->tnkv", shown_at, code)
        now = torch.cat(
            [3 * layout.touched(rows)[..., None], new[..., None, :].expand_as(seen)], -1
        )
        entry = torch.cat([read, was_shown, gated, now, events.by_object], -1)
        slots, slot_state = self.slots(entry.flatten(1, 2), before.slots)
        slots = slots.unflatten(1, tokens.shape[1:3]) * seen
        object_features, global_features, exact = [events.by_object], [events.clocks], events.kept
        if path is not None:
            to_all = path.remaining[..., None, :].expand(*path.by_object.shape[:-1], -1)
            object_features.append(torch.cat([path.by_object, to_all], -1))
            global_features.append(path.remaining)
            exact = torch.cat([exact, path.kept], -1)
        return Remembered(
            hidden=hidden,
            slots=slots,
            was_shown=was_shown,
            recalled=Recalled(shown[..., :3, :], predecessor, self.recall(slots)),
            state=MemoryState(bodies[-1], gru_state, slot_state, exact),
            object_features=object_features,
            global_features=global_features,
        )

    def follow_paths(self, rows, kept):
        """Path features; None if no paths are kept."""
        return paths(self.layout, rows, kept, self.path_points) if self.path_points else None

    def priors(self, tokens, was_shown, recalled, distance):
        """Features (T, N, tokens, N_PRIORS) of attention priors, by object."""
        of_objects = recalled.of_objects.detach()
        # Probability that the object first there has the colour of another visible one.
        colors = tokens[..., self.layout.part["color"]]
        predecessor_colors = torch.sigmoid(of_objects[..., : self.appearances]) @ self.colors()
        color_match = (predecessor_colors * (colors.sum(-2, keepdim=True) - colors)).sum(
            -1, keepdim=True
        )
        touched = torch.sigmoid(of_objects[..., -1:])
        remaining = was_shown[..., 1:2] * (1 - touched)
        # How many of the others have gone on more often.
        counts = (2 * of_objects[..., self.appearances : -1]).softmax(-1) * tokens[..., :1]
        more = counts.sum(-1, keepdim=True) - counts.cumsum(-1)
        exceeded = (counts * more.sum(-2, keepdim=True)).sum(-1, keepdim=True)
        exceeded = exceeded - (counts * more).sum(-1, keepdim=True)
        known = [color_match, touched, remaining, exceeded]
        return torch.cat([was_shown, *known, distance], -1)

    def reset_state(self, state, which):
        """The state with the memory of some environments (N,) reset to an episode's first step."""
        if state is None:
            return None
        retained = (~which).float()
        before = MemoryState(*state)
        tokens = before.bodies.shape[1]
        return MemoryState(
            before.bodies.masked_fill(which[:, None], -1),
            before.hidden * retained[None, :, None],
            before.slots * retained.repeat_interleave(tokens)[None, :, None],
            before.exact * retained[:, None, None],
        )

    @staticmethod
    def join(states):
        """One state of a batch, from states of batches of one."""
        axes = MemoryState(bodies=0, hidden=1, slots=1, exact=0)
        return MemoryState(*(torch.cat(parts, axis) for parts, axis in zip(zip(*states), axes)))

    @staticmethod
    def split(state):
        """States of batches of one, from that of a batch."""
        bodies, hidden, slots, exact = state
        tokens = bodies.shape[1]
        parts = bodies.split(1), hidden.split(1, 1), slots.split(tokens, 1), exact.split(1)
        return (MemoryState(*part) for part in zip(*parts))


class MemoryState(NamedTuple):
    """What a policy remembers between steps.

    bodies (N, tokens): of the last step; hidden, slots: states of both GRUs; exact (N, tokens,
    ...): what keyframes and paths keep.
    """

    bodies: torch.Tensor | None
    hidden: torch.Tensor | None
    slots: torch.Tensor | None
    exact: torch.Tensor | None


class Recalled(NamedTuple):
    """Predictions of the memory, logits with the shapes of `memory_loss.Labels`."""

    shown: torch.Tensor
    predecessor: torch.Tensor
    of_objects: torch.Tensor


class Remembered(NamedTuple):
    """What the memory gives for a sequence (T, N, ...).

    was_shown (T, N, tokens, 3): an object's appearance was shown in the first view, in any, and in
    which first. object_features, global_features: those of keyframes and, if kept, of paths.
    """

    hidden: torch.Tensor
    slots: torch.Tensor
    was_shown: torch.Tensor
    recalled: Recalled
    state: MemoryState
    object_features: list[torch.Tensor]
    global_features: list[torch.Tensor]


class Choice(NamedTuple):
    """Attention over objects, and an action for each.

    Log weights (T, N, tokens) of the objects; mean and logarithm of the standard
    deviation (T, N, tokens, actions) of the actions.
    """

    weights: torch.Tensor
    mean: torch.Tensor
    log_std: torch.Tensor

    def best(self):
        """The action (T, N, actions) for the object of most weight."""
        which = self.weights.argmax(-1)[..., None, None]
        return self.mean.take_along_dim(which, -2)[..., 0, :].clamp(-1, 1)

    def mixed(self):
        """Mean and log_std (T, N, actions) of the action, all objects weighed."""
        share = self.weights.exp()[..., None]
        return (share * self.mean).sum(-2), (share * self.log_std).sum(-2)


class PolicyOutput(NamedTuple):
    """A Choice; what the memory predicts, and its state; inputs of the choice, for a critic.

    recalled: None if the policy predicts nothing. state: None without a memory.
    """

    choice: Choice
    recalled: Recalled | None
    state: Any
    context: torch.Tensor


def groups(policy, lr, memory_lr, perception_lr):
    """Parameter groups of an optimiser: action, memory, perception and attention."""
    action = [policy.context_proj, policy.offset_proj, policy.act, policy.refine]
    memory = []
    if policy.memory:
        memory += [policy.encode, policy.norm, policy.gru, policy.shown]
        memory += [policy.global_proj, policy.object_proj, policy.slots, policy.recall]
    parts = [{id(p) for part in kind for p in part.parameters()} for kind in (action, memory)]
    chosen = [[p for p in policy.parameters() if id(p) in part] for part in parts]
    rest = [p for p in policy.parameters() if id(p) not in parts[0] | parts[1]]
    rates = (lr, memory_lr, perception_lr)
    return [{"params": p, "lr": r} for p, r in zip([*chosen, rest], rates) if p]


def can_act(layout, rows):
    """Steps (T, N) in which the number of visible objects is the episode's greatest.

    With frozen cues, the robot's actions have an effect from these steps on.
    """
    seen = layout.split(rows)[1][..., 0].sum(-1)
    return seen >= seen.amax(0)
