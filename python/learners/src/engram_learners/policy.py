"""Policy on object observations with an optional memory.

Observations are those of ``obs_mode="objects"``: the robot, then a token for every object.
Sequences are (T, N, ...) and begin where an episode begins.
"""

import math
from typing import NamedTuple

import torch
from torch import nn

from engram_learners.instructions import EMBEDDING, InstructionEncoder
from engram_learners.keyframes import N_CLOCK, N_KEPT, N_SINCE, arrivals, keyframes
from engram_learners.paths import N_LEFT, N_WAYS, path_size, paths
from engram_learners.rotations import alignments, angle, relative, tilt, turned, yaw

TOKEN = "object_"
N_APPEARANCES = 20  # pairs of colour and shape that are distinguished, by default
N_COUNTS = 8  # numbers of changes of a lamp or a button that are distinguished, by default
N_VIEWS = 8  # that are distinguished; later ones count as the last
N_MARKS = 4 + 7  # position encoding on the table: 4 values of x, 7 of y
TOUCH = 0.1  # most distance of the tool from an object's top, 0.05 m
STILL = 0.2 / math.pi  # most speed of a joint at rest, 0.2 rad/s
N_GATES = 5  # weights of turns of the tool
N_GEOMETRY = 3 + 5 + 5 + 2 + 2 + 4  # features of where an object is, seen from the tool
N_PRIORS = 8  # features of attention priors: seven of the memory, and the tool's distance


class ObservationLayout:
    """Offsets in a row of the objects observation, from the description of a batch.

    Of a policy of several tasks, behind the robot's numbers (`several_tasks.TaskInputs`):

    tasks: one-hot of the task.
    words: vocabulary of the bag of words of the instruction.
    """

    def __init__(self, description, tasks=0, words=()):
        fields = description["state_fields"]
        self.actions = description["action_dim"]
        # Whether the first three numbers of an action move the tool along x, y, z.
        self.moves_tool = description["control_mode"].startswith("pd_ee_delta_")
        self.tasks, self.words = tasks, list(words)
        robot = sum(f["width"] for f in fields if not f["name"].startswith(TOKEN))
        self.agent = robot + tasks + len(self.words)
        first = [f for f in fields if f["name"].startswith(f"{TOKEN}0_")]
        kinds = next(f["names"] for f in first if f["name"] == f"{TOKEN}0_kind")
        self.width = sum(f["width"] for f in first)
        self.tokens = tokens_of(description)
        begin = first[0]["offset"]
        self.part = {
            f["name"].removeprefix(f"{TOKEN}0_"): slice(
                f["offset"] - begin, f["offset"] - begin + f["width"]
            )
            for f in first
        }
        place = {f["name"]: slice(f["offset"], f["offset"] + f["width"]) for f in fields}
        self.tcp = slice(place["tcp_pose"].start, place["tcp_pose"].start + 3)
        self.tool = slice(place["tcp_pose"].start + 3, place["tcp_pose"].stop)
        self.turn = place.get("task_cue")  # by which an object is to turn
        self.arm_speed = slice(place["qvel"].start, place["qvel"].start + 7)
        self.place = self.part["position"]
        self.lamp, self.button = (
            self.part["kind"].start + kinds.index(kind) for kind in ("lamp", "button")
        )
        self.colors = self.part["color"].stop - self.part["color"].start
        self.shapes = self.part["shape"].stop - self.part["shape"].start
        self.appearance = [
            i for name in ("color", "shape", "kind") for i in indices(self.part[name])
        ]
        body = ("orientation", "size", "state", "kind")
        self.body = [i for name in body for i in indices(self.part[name])]

    @property
    def bag(self):
        """Where the bag of words begins."""
        return self.agent - len(self.words)

    def split(self, rows):
        """Rows (..., D) -> robot (..., agent), tokens (..., tokens, width).

        Rows may lack the last tokens, of objects that a task does not have.
        """
        tokens = rows[..., self.agent :].unflatten(-1, (-1, self.width))
        return rows[..., : self.agent], tokens

    def yaw(self, tokens):
        """Cosine and sine (..., tokens, 2) of the objects' turn about the vertical."""
        return yaw(tokens[..., self.part["orientation"]])

    def tool_yaw(self, agent):
        """Cosine and sine (..., 2) of the tool's turn about the vertical, from the robot's part."""
        if self.tool.start == self.tool.stop:  # proprio lacks it
            return torch.tensor([1.0, 0.0], device=agent.device).expand(*agent.shape[:-1], 2)
        return yaw(agent[..., self.tool])

    def geometry(self, rows):
        """Where every object is, seen from the tool (..., tokens, N_GEOMETRY)."""
        agent, tokens = self.split(rows)
        offset = tokens[..., self.place] - agent[..., None, self.tcp]
        turn = relative(self.tool_yaw(agent)[..., None, :], self.yaw(tokens))
        half, quarter = alignments(turn)
        along = turned(self.yaw(tokens), offset[..., :2], back=True)
        ways = torch.cat([offset, along], -1)
        scales = [5 * offset, (20 * ways).tanh(), (80 * ways).tanh(), 5 * along]
        angles = torch.stack([half, quarter, (10 * half).tanh(), (10 * quarter).tanh()], -1)
        return torch.cat([*scales, turn, angles], -1) * tokens[..., :1]

    def to_top(self, rows):
        """Vectors from the tool to the top of every object (..., tokens, 3)."""
        agent, tokens = self.split(rows)
        top = tokens[..., self.place].clone()
        top[..., 2] += 0.1 * tokens[..., self.part["size"]][..., 2]  # 0.05 m to 0.5 m
        return top - agent[..., None, self.tcp]

    def servo(self, rows, own, gates):
        """Actions by object (..., tokens, actions) of a servo to its top, as the oracle's gain.

        own (..., tokens, 2): a motion along the object's own horizontal axes, added as well.
        gates (..., tokens, N_GATES): weights of turns: to be upright; none, to face ahead, to be
        aligned with the object, where it looks the same after half a turn, or a quarter.
        """
        agent, tokens = self.split(rows)
        if not self.moves_tool:
            return 0.0
        direction, tool = self.yaw(tokens), self.tool_yaw(agent)[..., None, :]
        reach = (8 * self.to_top(rows)).clamp(-3, 3)
        reach = reach + nn.functional.pad(turned(direction, own), (0, 1))
        if self.actions < 7 or self.tool.start == self.tool.stop:
            return nn.functional.pad(reach, (0, self.actions - 3))
        turns = [relative(tool, torch.tensor([1.0, 0], device=tool.device))]
        turns = [angle(turns[0]).expand(*tokens.shape[:-1]), *alignments(relative(tool, direction))]
        share = gates[..., 1:].softmax(-1)[..., 1:]
        turn = (share * torch.stack(turns, -1)).sum(-1, keepdim=True)
        upright = gates[..., :1].sigmoid() * tilt(agent[..., None, self.tool])
        rotation = -16 * torch.cat([upright, turn], -1)  # the benchmark negates rotations
        return torch.cat([reach, rotation, torch.zeros_like(turn)], -1)

    def touched(self, rows):
        """Visible objects (..., tokens) at whose top the tool rests."""
        agent, tokens = self.split(rows)
        near = self.to_top(rows).norm(dim=-1) < TOUCH
        still = (agent[..., self.arm_speed].abs() < STILL).all(-1, keepdim=True)
        return near & still & (tokens[..., 0] > 0)

    def pairs(self, tokens):
        """Index of every object's pair of colour and shape (or none); -1 for invisible objects."""
        color = tokens[..., self.part["color"]].argmax(-1)
        shape = tokens[..., self.part["shape"]]
        shape = torch.where(shape.sum(-1) > 0, shape.argmax(-1), self.shapes)
        return torch.where(tokens[..., 0] > 0, color * (self.shapes + 1) + shape, -1)

    def bodies(self, tokens, pairs):
        """The pairs, with one index for all lamps, because their colours may change."""
        lamp = tokens[..., self.lamp] > 0
        return torch.where(lamp, self.colors * (self.shapes + 1), pairs)


def tokens_of(task):
    """Objects of a task, from its description with objects observations."""
    return sum(field["name"].endswith("_seen") for field in task["state_fields"])


def view_code(was_shown):
    """The first view (..., N_VIEWS) of objects that were shown before, about one-hot."""
    views = torch.arange(N_VIEWS, device=was_shown.device)
    away = N_VIEWS * was_shown[..., 2:] - views
    return torch.exp(-((away / 0.5) ** 2)) * was_shown[..., 1:2]


def indices(part):
    return range(part.start, part.stop)


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
        n_left, n_ways = (N_LEFT, N_WAYS) if self.path_points else (0, 0)
        self.layout, self.memory = layout, memory
        self.predicts = memory  # what has been shown, for the memory's loss
        self.register_buffer("mean", torch.zeros(layout.agent))
        self.register_buffer("std", torch.ones(layout.agent))
        self.register_buffer("vocabulary", torch.full((appearances,), -2))
        self.instruction = InstructionEncoder(len(layout.words)) if layout.words else None
        agent = layout.bag + (EMBEDDING if layout.words else 0)
        self.read = mlp(layout.width + 3, token, token)
        seen = agent + token
        kept = hidden + slot + N_PRIORS + N_CLOCK + n_left if memory else 0
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
        self.query = nn.Linear(seen + kept, token)
        object_width = token + (slot + N_PRIORS + N_VIEWS if memory else 0)
        self.key = nn.Linear(object_width, token)
        self.context_proj = nn.Linear(seen + kept, width)
        here = N_GEOMETRY + len(layout.body) + (N_SINCE + 1 if memory else 0)
        here += n_ways + n_left
        self.offset_proj = nn.Linear(here, width, bias=False)
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
        """Continues from a state; None begins an episode.

        -> Choice; predictions of the memory, or None; its state; inputs of the choice (T, N, ...),
        for a critic.
        """
        layout = self.layout
        agent, tokens = layout.split(rows)
        seen = tokens[..., :1]
        offset = 5 * (tokens[..., layout.place] - agent[..., None, layout.tcp]) * seen
        read = self.read(torch.cat([tokens, offset], -1)) * seen
        scaled = self.scale(agent)
        priors = distance = offset[..., :2].norm(dim=-1, keepdim=True)
        parts, objects, recalled = [scaled, read.sum(-2)], read, None
        here = [layout.geometry(rows), tokens[..., layout.body]]
        if self.memory:
            known, slots, was_shown, recalled, state, (since, times) = self.remember(
                rows, scaled, read, state
            )
            priors = self.priors(tokens, was_shown, recalled, distance)
            parts += [known, slots.sum(-2), (priors * seen).sum(-2)]
            objects = torch.cat([read, 4 * priors, slots, view_code(was_shown)], -1)
            here += [*since, torch.sigmoid(recalled[2][..., -1:].detach())]
            parts.extend(times)
        known = torch.cat(parts, -1)
        match = (self.key(objects) * self.query(known)[..., None, :]).sum(-1)
        match = match / math.sqrt(read.shape[-1]) + priors @ self.prior_gain
        weights = match.masked_fill(seen[..., 0] == 0, -1e4).log_softmax(-1)
        # The action sees neither appearances nor weights: it is the same function for all objects.
        here = torch.cat(here, -1)
        hidden = torch.tanh(self.context_proj(known)[..., None, :] + self.offset_proj(here))
        n = layout.actions
        mean, deviation, own, gates = self.act(hidden).split([n, n, 2, N_GATES], -1)
        # Initial action: toward the chosen object. (Otherwise the opposite direction is as good.)
        mean = mean + layout.servo(rows, own, gates)
        mean = mean + self.refine(torch.cat([hidden, mean.clamp(-1, 1)], -1))
        attended = (weights.exp()[..., None] * torch.cat([here, objects], -1)).sum(-2)
        context = torch.cat([known, attended], -1)
        return Choice(weights, mean, (deviation - 1.0).clamp(-5.0, 0.0)), recalled, state, context

    def scale(self, agent):
        """The robot's numbers, normalised, and the embedding of the instruction."""
        scaled = ((agent - self.mean) / self.std).clamp(-5, 5)
        if self.instruction is None:
            return scaled
        numbers = scaled[..., : self.layout.bag]
        words = self.instruction(agent[:1, ..., self.layout.bag :])  # the same in all steps
        return torch.cat([numbers, words.expand(*numbers.shape[:-1], -1)], -1)

    def remember(self, rows, scaled, read, state):
        """Integrates a sequence, starting from a state.

        -> global features; features by object; by object (T, N, tokens, 3): its appearance was
        shown in the first view, in any, and in which first; predictions; the memory's state.
        """
        layout = self.layout
        tokens = layout.split(rows)[1]
        seen, pairs = tokens[..., :1], layout.pairs(tokens)
        bodies = layout.bodies(tokens, pairs)
        before, state, slot_state, kept = state or (None, None, None, None)
        new = arrivals(bodies, before)
        kept = (None, None) if kept is None else (kept[..., :N_KEPT], kept[..., N_KEPT:])
        since, clocks, kept_events = keyframes(layout, rows, new, kept[0])
        ways, left, kept_paths = self.follow_paths(rows, kept[1])
        kept = torch.cat([kept_events, *kept_paths], -1)
        code = self.code(pairs)
        plain = torch.cat([tokens[..., layout.appearance], tokens[..., layout.place]], -1)
        marks = position_encoding(tokens[..., layout.place])
        bound = torch.einsum("tnkp,tnkc->tnpc", marks, code).flatten(-2)
        entry = torch.cat([scaled, 3 * code.sum(-2), 3 * bound, plain.sum(-2), new], -1)
        known, state = self.gru(self.norm(self.encode(entry)), state)
        shown = self.shown(known).unflatten(-1, (3 + N_MARKS, self.appearances))
        known = known.detach()
        predecessor = torch.einsum("tnpc,tnkp->tnkc", shown[..., 3:, :], marks)
        gated = self.global_proj(known)[..., None, :] * self.object_proj(
            torch.cat([read, plain], -1)
        )
        gated = torch.cat([gated, torch.sigmoid(predecessor.detach())], -1)
        shown_at = torch.sigmoid(shown[..., :3, :].detach())
        was_shown = torch.einsum("tnvc,tnkc->tnkv", shown_at, code)
        now = torch.cat(
            [3 * layout.touched(rows)[..., None], new[..., None, :].expand_as(seen)], -1
        )
        entry = torch.cat([read, was_shown, gated, now, since], -1)
        slots, slot_state = self.slots(entry.flatten(1, 2), slot_state)
        slots = slots.unflatten(1, tokens.shape[1:3]) * seen
        recalled = (shown[..., :3, :], predecessor, self.recall(slots))
        state = bodies[-1], state, slot_state, kept
        return known, slots, was_shown, recalled, state, ([since, *ways], [clocks, *left])

    def follow_paths(self, rows, kept):
        """Features by object, global ones and state of `paths`, each in a list.

        The lists are empty if no paths are kept.
        """
        if not self.path_points:
            return [], [], []
        ways, left, kept = paths(self.layout, rows, kept, self.path_points)
        by_object = left[..., None, :].expand(*ways.shape[:-1], -1)
        return [torch.cat([ways, by_object], -1)], [left], [kept]

    def priors(self, tokens, was_shown, recalled, distance):
        """Features (T, N, tokens, N_PRIORS) of attention priors, by object."""
        of_objects = recalled[2].detach()
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

    def wipe(self, state, which):
        """The state with the memory of some environments (N,) reset to an episode's first step."""
        if state is None:
            return None
        retained = (~which).float()
        before, known, slots, kept = state
        return (
            before.masked_fill(which[:, None], -1),
            known * retained[None, :, None],
            slots * retained.repeat_interleave(before.shape[1])[None, :, None],
            kept * retained[:, None, None],
        )

    @staticmethod
    def join(states):
        """One state of a batch, from states of batches of one."""
        return tuple(torch.cat(parts, axis) for parts, axis in zip(zip(*states), (0, 1, 1, 0)))

    @staticmethod
    def split(state):
        """States of batches of one, from that of a batch."""
        before, known, slots, kept = state
        tokens = before.shape[1]
        return zip(before.split(1), known.split(1, 1), slots.split(tokens, 1), kept.split(1))


class Choice(NamedTuple):
    """Attention over objects, and an action for each.

    Log weights (T, N, tokens) of the objects; mean and log deviation (T, N, tokens, actions) of the
    actions.
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
