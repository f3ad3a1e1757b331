"""A policy that sees objects and may remember: networks, and what its memory is taught.

Observations are those of ``obs_mode="objects"``: the robot, then a token for every object.
Sequences are (T, N, ...) and begin where an episode begins.
"""

import math
from typing import NamedTuple

import torch
from torch import nn
from torch.nn.functional import binary_cross_entropy_with_logits

TOKEN = "object_"
LOOKS = 20  # of an id's looks are told apart
COUNTS = 8  # so many changes of a lamp or a button are told apart
PLACES = 4 + 7  # marks of the table
TOUCH = 0.1  # of the tool at an object's top: within 0.05 m
STILL = 0.2 / math.pi  # no joint of the arm is faster: 0.2 rad/s
NEAR = 0.1  # of the same place: within 0.05 m
ON, OFF = 0.35, 0.2  # a lamp is lit, a button pressed, from ON until OFF
LIFTED = 0.17  # a press is over when the tool is 0.085 m above where it began
LIKES = 7  # what the memory says of an object in a word, and how far the tool is


class Sight:
    """Where things lie in a row of the objects observation, by the description of a batch."""

    def __init__(self, description):
        fields = description["state_fields"]
        self.agent = sum(f["width"] for f in fields if not f["name"].startswith(TOKEN))
        first = [f for f in fields if f["name"].startswith(f"{TOKEN}0_")]
        kinds = next(f["names"] for f in first if f["name"] == f"{TOKEN}0_kind")
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
        self.arm_speed = slice(place["qvel"].start, place["qvel"].start + 7)
        self.place = self.part["position"]
        self.lamp, self.button = (
            self.part["kind"].start + kinds.index(kind) for kind in ("lamp", "button")
        )
        self.colors = self.part["color"].stop - self.part["color"].start
        self.shapes = self.part["shape"].stop - self.part["shape"].start
        self.look = [i for name in ("color", "shape", "kind") for i in indices(self.part[name])]
        body = ("orientation", "size", "state", "kind")
        self.body = [i for name in body for i in indices(self.part[name])]

    def split(self, rows):
        """Rows (..., D) -> robot (..., agent), tokens (..., tokens, width)."""
        tokens = rows[..., self.agent :].unflatten(-1, (self.tokens, self.width))
        return rows[..., : self.agent], tokens

    def to_top(self, rows):
        """From the tool to the top of every object (..., tokens, 3)."""
        agent, tokens = self.split(rows)
        top = tokens[..., self.place].clone()
        top[..., 2] += 0.1 * tokens[..., self.part["size"]][..., 2]  # 0.05 m to 0.5 m
        return top - agent[..., None, self.tcp]

    def touched(self, rows):
        """Whether the tool rests at the top of every object (..., tokens), if it is seen."""
        agent, tokens = self.split(rows)
        near = self.to_top(rows).norm(dim=-1) < TOUCH
        still = (agent[..., self.arm_speed].abs() < STILL).all(-1, keepdim=True)
        return near & still & (tokens[..., 0] > 0)

    def pairs(self, tokens):
        """Number of every object's pair of colour and shape (or none); -1 of what is not seen."""
        color = tokens[..., self.part["color"]].argmax(-1)
        shape = tokens[..., self.part["shape"]]
        shape = torch.where(shape.sum(-1) > 0, shape.argmax(-1), self.shapes)
        return torch.where(tokens[..., 0] > 0, color * (self.shapes + 1) + shape, -1)

    def bodies(self, tokens, pairs):
        """The pairs, but a lamp has one number whatever its colour, because that may change."""
        lamp = tokens[..., self.lamp] > 0
        return torch.where(lamp, self.colors * (self.shapes + 1), pairs)


def indices(part):
    return range(part.start, part.stop)


def at_places(where):
    """Which marks on the table (..., PLACES) a place (..., 3) is near, from both sides of it."""
    x = torch.linspace(-0.5, 0.7, 4, device=where.device)
    y = torch.linspace(-0.6, 0.6, 7, device=where.device)
    away = torch.cat([where[..., :1] - x, where[..., 1:2] - y], -1)
    return torch.exp(-((away / 0.2) ** 2))


def arrivals(bodies, before=None):
    """Steps (T, N, 1) in which something comes into sight.

    Then a new view begins, in which every object keeps its token. bodies (T, N, tokens): as of
    `Sight.bodies`; what has another one is another object. before: those (N, tokens) before the
    first step, None for nothing.
    """
    earlier = torch.full_like(bodies[:1], -1) if before is None else before[None]
    earlier = torch.cat([earlier, bodies[:-1]])
    return ((bodies >= 0) & (bodies != earlier)).any(-1, keepdim=True).float()


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
    """Reads tokens one by one, and picks one out for the hand.

    A GRU remembers the sum of what is seen; a second one, the same for all objects, remembers of
    each what the first says of it, as long as it can be followed. Without memory there are no GRUs.
    """

    def __init__(self, sight, memory=True, hidden=64, width=64, token=32, slot=32, actions=7):
        super().__init__()
        self.sight, self.memory = sight, memory
        self.register_buffer("mean", torch.zeros(sight.agent))
        self.register_buffer("std", torch.ones(sight.agent))
        self.register_buffer("vocabulary", torch.full((LOOKS,), -2))
        self.read = mlp(sight.width + 3, token, token)
        seen = sight.agent + token
        kept = hidden + slot + LIKES if memory else 0
        if memory:
            plain = LOOKS * (1 + PLACES) + len(sight.look) + 3
            # What is seen goes into the memory as it is, too: it is then quickly learnt to keep.
            self.encode = mlp(sight.agent + plain + 1, hidden)
            self.norm = nn.LayerNorm(hidden)
            self.gru = nn.GRU(hidden, hidden)
            self.tell = nn.Linear(hidden, slot)
            self.about = nn.Linear(token + len(sight.look) + 3, slot)
            self.shown = nn.Linear(hidden, (3 + PLACES) * LOOKS)
            self.slots = nn.GRU(token + slot + 5 + LOOKS, slot)
            self.recall = nn.Linear(slot, Recollection.WIDTH)
            # Answers that differ from the first are sooner learnt to be right.
            with torch.no_grad():
                self.shown.weight *= 5
                self.recall.weight *= 3
        # Inborn: memory looks at what was shown and is not yet touched, and at what hides such.
        # Without any, it looks at what is near: so it gets to one of them, not between them.
        self.liking = nn.Parameter(torch.tensor([0.0, 0, 0, 4, 0, 4, 0] if memory else [-8.0]))
        self.question = nn.Linear(seen + kept, token)
        thing = token + (slot + LIKES if memory else 0)
        self.key = nn.Linear(thing, token)
        self.situation = nn.Linear(seen + kept, width)
        self.toward = nn.Linear(3 + len(sight.body), width, bias=False)
        self.act = mlp(width, width, 2 * actions, gain=0.01)

    def fit(self, rows):
        """Takes the scale of the robot's numbers, and the looks there are, from these."""
        agent, tokens = self.sight.split(rows)
        agent = agent.flatten(0, -2)
        self.mean.copy_(agent.mean(0))
        self.std.copy_(agent.std(0) + 1e-2)
        pairs = self.sight.pairs(tokens).unique()
        pairs = pairs[pairs >= 0][:LOOKS]
        self.vocabulary[: len(pairs)] = pairs

    def colors(self):
        """One-hot colours (LOOKS, colours) of the looks there are."""
        color = self.vocabulary.div(self.sight.shapes + 1, rounding_mode="floor")
        return (color[:, None] == torch.arange(self.sight.colors, device=color.device)).float()

    def code(self, pairs):
        """One-hot looks (..., LOOKS) of every object, from its pair."""
        return (pairs[..., None] == self.vocabulary).float()

    def forward(self, rows, state=None):
        """Goes on from a state; None begins an episode.

        -> Choice; what the memory recollects, None without; its state; what the choice comes from
        (T, N, ...), for a critic.
        """
        sight = self.sight
        agent, tokens = sight.split(rows)
        seen = tokens[..., :1]
        offset = 5 * (tokens[..., sight.place] - agent[..., None, sight.tcp]) * seen
        read = self.read(torch.cat([tokens, offset], -1)) * seen
        scaled = ((agent - self.mean) / self.std).clamp(-5, 5)
        likes = away = offset[..., :2].norm(dim=-1, keepdim=True)
        parts, things, recalled = [scaled, read.sum(-2)], read, None
        if self.memory:
            known, slots, familiar, recalled, state = self.remember(rows, scaled, read, state)
            likes = self.likes(tokens, familiar, recalled, away)
            parts += [known, slots.sum(-2), (likes * seen).sum(-2)]
            things = torch.cat([read, 4 * likes, slots], -1)
        known = torch.cat(parts, -1)
        match = (self.key(things) * self.question(known)[..., None, :]).sum(-1)
        match = match / math.sqrt(read.shape[-1]) + likes @ self.liking
        weights = match.masked_fill(seen[..., 0] == 0, -1e4).log_softmax(-1)
        # The hand knows neither looks nor which object is meant: it learns to reach all alike.
        here = torch.cat([offset, tokens[..., sight.body]], -1)
        hand = torch.tanh(self.situation(known)[..., None, :] + self.toward(here))
        mean, deviation = self.act(hand).chunk(2, -1)
        # Inborn: it goes to what is picked. (Else an action toward the opposite one is as good.)
        reach = (5 * sight.to_top(rows)).clamp(-1, 1)
        mean = torch.cat([mean[..., :3] + reach, mean[..., 3:]], -1)
        attended = (weights.exp()[..., None] * torch.cat([here, things], -1)).sum(-2)
        context = torch.cat([known, attended], -1)
        return Choice(weights, mean, (deviation - 1.0).clamp(-5.0, 0.0)), recalled, state, context

    def remember(self, rows, scaled, read, state):
        """Reads a sequence, on from a state.

        -> what is known of all, and of every object; of every object (T, N, tokens, 3) whether its
        look was shown at first, whether ever, and when; what is recollected; the memory's state.
        """
        sight = self.sight
        tokens = sight.split(rows)[1]
        seen, pairs = tokens[..., :1], sight.pairs(tokens)
        bodies = sight.bodies(tokens, pairs)
        before, state, slot_state = state or (None, None, None)
        new = arrivals(bodies, before)
        code = self.code(pairs)
        plain = torch.cat([tokens[..., sight.look], tokens[..., sight.place]], -1)
        marks = at_places(tokens[..., sight.place])
        put = torch.einsum("tnkp,tnkc->tnpc", marks, code).flatten(-2)
        entry = torch.cat([scaled, 3 * code.sum(-2), 3 * put, plain.sum(-2), new], -1)
        known, state = self.gru(self.norm(self.encode(entry)), state)
        shown = self.shown(known).unflatten(-1, (3 + PLACES, LOOKS))
        known = known.detach()
        stood = torch.einsum("tnpc,tnkp->tnkc", shown[..., 3:, :], marks)
        told = self.tell(known)[..., None, :] * self.about(torch.cat([read, plain], -1))
        told = torch.cat([told, torch.sigmoid(stood.detach())], -1)
        shown_at = torch.sigmoid(shown[..., :3, :].detach())
        familiar = torch.einsum("tnvc,tnkc->tnkv", shown_at, code)
        now = torch.cat([3 * sight.touched(rows)[..., None], new[..., None, :].expand_as(seen)], -1)
        entry = torch.cat([read, familiar, told, now], -1)
        slots, slot_state = self.slots(entry.flatten(1, 2), slot_state)
        slots = slots.unflatten(1, tokens.shape[1:3]) * seen
        recalled = (shown[..., :3, :], stood, self.recall(slots))
        return known, slots, familiar, recalled, (bodies[-1], state, slot_state)

    def likes(self, tokens, familiar, recalled, away):
        """What the memory says of every object in a word, and how far the tool is.

        -> (T, N, tokens, LIKES)
        """
        of_objects = recalled[2].detach()
        # Whether what stood there has the colour of something else that is in sight now.
        colors = tokens[..., self.sight.part["color"]]
        stood_colors = torch.sigmoid(of_objects[..., :LOOKS]) @ self.colors()
        meant = (stood_colors * (colors.sum(-2, keepdim=True) - colors)).sum(-1, keepdim=True)
        touched = torch.sigmoid(of_objects[..., -1:])
        left = familiar[..., 1:2] * (1 - touched)
        return torch.cat([familiar, meant, touched, left, away], -1)

    def wipe(self, state, which):
        """The state with the memory of some environments (N,) as in an episode's first step."""
        if state is None:
            return None
        keep = (~which).float()
        before, known, slots = state
        return (
            before.masked_fill(which[:, None], -1),
            known * keep[None, :, None],
            slots * keep.repeat_interleave(self.sight.tokens)[None, :, None],
        )


class Choice(NamedTuple):
    """An object to act upon, and how.

    Log weights (T, N, tokens) of the objects; mean and log deviation (T, N, tokens, actions) of the
    action for each.
    """

    weights: torch.Tensor
    mean: torch.Tensor
    deviation: torch.Tensor

    def best(self):
        """The action (T, N, actions) for the object of most weight."""
        which = self.weights.argmax(-1)[..., None, None]
        return self.mean.take_along_dim(which, -2)[..., 0, :].clamp(-1, 1)

    def mixed(self):
        """Mean and log deviation (T, N, actions) of the action, all objects weighed."""
        share = self.weights.exp()[..., None]
        return (share * self.mean).sum(-2), (share * self.deviation).sum(-2)


def groups(policy, lr, memory_lr, sight_lr):
    """Parameters for an optimiser, by rate.

    The hand; the memory; what reads objects and picks one out.
    """
    hand = [policy.situation, policy.toward, policy.act]
    memory = []
    if policy.memory:
        memory += [policy.encode, policy.norm, policy.gru, policy.shown]
        memory += [policy.tell, policy.about, policy.slots, policy.recall]
    parts = [{id(p) for part in kind for p in part.parameters()} for kind in (hand, memory)]
    chosen = [[p for p in policy.parameters() if id(p) in part] for part in parts]
    rest = [p for p in policy.parameters() if id(p) not in parts[0] | parts[1]]
    rates = (lr, memory_lr, sight_lr)
    return [{"params": p, "lr": r} for p, r in zip([*chosen, rest], rates) if p]


class Recollection:
    """What the memory is taught to know, by the episode's own observations: no privileged label.

    * shown: of every look, whether something had it in the first view, or in any earlier one, and
      in which first.
    * stood: of every object in sight, the looks of what stood in its place at first, carried along
      as it moves.
    * changed: of every object in sight, how often it (a lamp, a button) has gone on.
    * touched: of every object in sight, whether the tool has rested at its top; of a button,
      whether it has been pressed and the tool has not been lifted since.
    """

    VIEWS = 8  # later ones are told like the eighth
    WIDTH = LOOKS + COUNTS + 1

    @classmethod
    def labels(cls, policy, rows):
        """Of whole episodes (T, N, D).

        -> shown (T, N, 3, LOOKS); what stood at the place of every object (T, N, tokens, LOOKS);
        what is known of every object (T, N, tokens, WIDTH).
        """
        tokens = policy.sight.split(rows)[1]
        pairs = policy.sight.pairs(tokens)
        new = arrivals(policy.sight.bodies(tokens, pairs))[..., 0]
        view = new.cumsum(0)[..., None] - 1
        code = policy.code(pairs)
        first = torch.where(code.amax(-2) > 0, view, cls.VIEWS).cummin(0).values
        shown = torch.stack([first == 0, first < view, first.clamp(max=cls.VIEWS) / cls.VIEWS], -2)
        here = stood_here(policy.sight, tokens, code)
        return shown, here, torch.cat(followed(policy.sight, rows, code, new), -1)

    @staticmethod
    def loss(policy, rows, recalled, labels):
        seen = policy.sight.split(rows)[1][..., 0]
        (shown, stood, of_objects), (shown_label, here, object_label) = recalled, labels
        error = binary_cross_entropy_with_logits(shown, shown_label, reduction="none")
        # Looks that the episode never shows are not asked for: so many a no would drown the rest.
        error = error * shown_label[-1, ..., 2:, :].lt(1)
        error[..., 2, :] *= shown_label[..., 1, :]
        of_all = error.sum((-1, -2)).mean()
        known = torch.cat([policy.vocabulary >= 0, policy.vocabulary.new_ones(COUNTS + 1) > 0])
        error = binary_cross_entropy_with_logits(of_objects, object_label, reduction="none") * known
        of_places = binary_cross_entropy_with_logits(stood, here, reduction="none")
        error = error.sum(-1) + (of_places * known[:LOOKS]).sum(-1)
        return of_all + (error * seen).sum() / seen.sum()


def stood_here(sight, tokens, looks):
    """Looks of what stood at the place of every object (T, N, tokens, LOOKS) at first."""
    where = tokens[..., sight.place][..., :2]
    away = (where[:, :, :, None] - where[0][None, :, None]).norm(dim=-1)
    away = away.masked_fill(tokens[0, ..., 0][None, :, None] == 0, 9)
    near, which = away.min(-1)
    stood = looks[:1].expand_as(looks).gather(2, which[..., None].expand_as(looks))
    return stood * (near < NEAR)[..., None] * tokens[..., :1]


def followed(sight, rows, looks, new):
    """What is known of every object, followed from view to view by its place.

    -> looks of what stood there at first, number of changes (one-hot), touched.
    """
    agent, tokens = sight.split(rows)
    where = tokens[..., sight.place][..., :2]
    seen = tokens[..., 0] > 0
    state = tokens[..., sight.part["state"]][..., 0]
    button = tokens[..., sight.button] > 0
    height = agent[..., sight.tcp][..., 2:].expand_as(state)
    touched_now = sight.touched(rows).float()
    # Of every object: looks, changes, touched, the tool's height when it went on.
    at_first = known = nn.functional.pad(looks[0], (0, 3))
    result, on = [], state[0] >= ON
    for t in range(len(tokens)):
        if t > 0 and new[t].any():
            moved = carried(
                known, (where[t - 1], seen[t - 1]), at_first, (where[0], seen[0]), where[t]
            )
            known = torch.where(new[t][:, None, None] > 0, moved * seen[t][..., None], known)
        same_view = (new[t] == 0)[:, None]
        was_on, on = on, (state[t] >= ON) | (on & (state[t] > OFF) & same_view)
        goes_on = on & ~was_on & same_view
        changes, touched, began = known[..., -3:].unbind(-1)
        began = torch.where(goes_on, height[t], began)
        pressed = goes_on | (touched > 0) & (height[t] < began + LIFTED)
        touched = torch.where(button[t], pressed.float(), torch.maximum(touched, touched_now[t]))
        kept = torch.stack([changes + goes_on, touched, began], -1)
        known = torch.cat([known[..., :-3], kept], -1)
        result.append(known)
    stood, changes, touched, _ = torch.stack(result).split([looks.shape[-1], 1, 1, 1], -1)
    counts = changes[..., 0].long().clamp(max=COUNTS - 1)
    return stood, nn.functional.one_hot(counts, COUNTS).float(), touched


def carried(known, last, at_first, first, where):
    """What is known of the objects at these places in a new view.

    It is what was known of what stood there last, else of what stood there at first.
    """
    away = torch.cdist(where, torch.cat([last[0], first[0]], 1))
    away = away.masked_fill(~torch.cat([last[1], first[1]], 1)[:, None], 9)
    away[..., known.shape[1] :] += NEAR
    away, which = away.min(-1)
    source = torch.cat([known, at_first], 1)
    return source.gather(1, which[..., None].expand_as(known)) * (away < 2 * NEAR)[..., None]


def can_act(sight, rows):
    """Steps (T, N) in which as much is seen as ever in the episode.

    Where cues are frozen, the robot's actions count from there on.
    """
    seen = sight.split(rows)[1][..., 0].sum(-1)
    return seen >= seen.amax(0)
