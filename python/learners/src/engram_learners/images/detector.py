"""Object detector: from both cameras to objects in the form of the objects observation.

A heat map over the table (base camera, seen from above) proposes places. A second network looks at
a patch of both cameras' images around a place: what is there, and how far from it. It also looks
where each object was in the step before, given its class: so objects that the hand occludes are
retained, and those that are taken away are not. Every object keeps its token.

Labels are the visible objects of the objects observation, privileged and used in training only.
"""

import copy
from typing import NamedTuple

import torch
from torch import nn
from torch.nn.functional import cross_entropy, max_pool2d, one_hot, smooth_l1_loss

from engram_learners.images.pose_refiner import PoseRefiner
from engram_learners.images.views import (
    METRES,
    ROBOT,
    TURNING,
    apparent,
    base_view,
    project,
    robot_features,
    sample,
    wrist_view,
)
from engram_learners.rotations import about_vertical, direction_of

HEIGHT = 0.02  # of the plane of the heat map
STEP, CELL = 0.01, 0.02  # metres of its input's pixels and of its cells
PATCH, PIXEL = 16, 0.0055  # side of a patch in pixels, and metres of one
NEAR = 0.035  # most distance of a proposal from its object
MOVED = 0.08  # most way of an object in a step
KEPT = 0.9  # share of the evidence that remains in a step
SAME = 0.025  # objects of one appearance that are nearer are one


class Objects(NamedTuple):
    """By token: positions (N, tokens, 3) in metres, classes (N, tokens), -1 for none, and turns.

    Turns (N, tokens, 2) about the vertical, cosine and sine, of long objects only. They begin
    within a quarter of a turn, and go on from there.
    """

    place: torch.Tensor
    known: torch.Tensor
    turn: torch.Tensor


class Tracks(NamedTuple):
    """Objects, and their classes' evidence (N, tokens, classes): sums of log-probabilities."""

    place: torch.Tensor
    known: torch.Tensor
    turn: torch.Tensor
    evidence: torch.Tensor


class Examples(NamedTuple):
    """Places (B, P, 3) to look at, with the classes (B, P) before, or -1.

    target (B, P): classes to find, -1 for nothing, -2 for no example; place (B, P, 3): positions to
    find.
    """

    places: torch.Tensor
    known: torch.Tensor
    target: torch.Tensor
    place: torch.Tensor


def detector_layout(layout, tokens):
    """Layout of the rows that an ObjectDetector makes."""
    result = copy.copy(layout)
    robot = robot_numbers(layout)
    result.agent = robot + layout.tasks + len(layout.words)
    result.tcp, result.tokens = slice(0, 3), tokens
    result.arm_speed = slice(0, 0)  # proprio lacks it: a touch needs no rest
    result.tool = slice(ROBOT, robot - 1) if layout.turn else slice(0, 0)
    result.turn = slice(robot - 1, robot) if layout.turn else None
    return result


def robot_numbers(layout):
    """Numbers of the robot in the rows of a detector."""
    return ROBOT + (TURNING if layout.turn else 0)


def centres(low, high, step):
    return torch.arange(float(low) + step / 2, float(high), step)


def table(extent, step):
    """Points (lines, columns, 3) of the table in an extent of x and y."""
    x, y = (centres(low, high, step) for low, high in extent)
    x, y = torch.meshgrid(x, y, indexing="ij")
    return torch.stack([x, y, torch.full_like(x, HEIGHT)], -1)


def around():
    """Points of a patch around its centre (PATCH * PATCH, 3)."""
    side = PIXEL * (torch.arange(PATCH) - (PATCH - 1) / 2)
    x, y = torch.meshgrid(side, side, indexing="ij")
    return torch.stack([x, y, torch.zeros_like(x)], -1).flatten(0, 1)


class ObjectDetector(nn.Module):
    """Arguments: those of `vocabulary`.

    codes: of the classes; templates: a token of each; bodies: that of each. tokens: the body of
    each token. extent: of the heat map, in metres: low and high of x, and of y. turning: which
    classes are long, so that their turn is seen; None if none is.
    """

    BUFFERS = ("codes", "templates", "bodies", "tokens", "extent")

    def __init__(self, codes, templates, bodies, tokens, extent, turning=None):
        super().__init__()
        self.refiner = None
        if turning is not None:
            self.register_buffer("turning", turning)
            self.refiner = PoseRefiner()
        self.register_buffer("codes", codes)
        self.register_buffer("templates", templates)
        self.register_buffer("bodies", bodies)
        self.register_buffer("tokens", tokens)
        self.register_buffer("extent", extent)
        points = table(extent, STEP)
        pixels = project(points.view(1, -1, 3), base_view())
        self.register_buffer("pixels", pixels.view(*points.shape[:2], 2), persistent=False)
        self.register_buffer("cells", table(extent, CELL), persistent=False)
        self.register_buffer("around", around(), persistent=False)
        self.heat = nn.Sequential(
            nn.Conv2d(3, 12, 5, 2, 2), nn.ReLU(), nn.Conv2d(12, 16, 3, 1, 1), nn.ReLU()
        )
        self.peak = nn.Conv2d(16, 1, 1)
        nn.init.constant_(self.peak.bias, -4.0)
        self.look = nn.Sequential(
            nn.Conv2d(6, 24, 3, 2, 1),
            nn.ReLU(),
            nn.Conv2d(24, 32, 3, 2, 1),
            nn.ReLU(),
            nn.Flatten(),
        )
        self.read = nn.Sequential(nn.Linear(512 + 6 + len(codes) + 1, 64), nn.ReLU())
        self.name = nn.Linear(64, len(codes) + 1)  # the last: nothing
        self.shift = nn.Linear(64, 3)

    @classmethod
    def of_weights(cls, weights):
        if not weights.keys() >= set(cls.BUFFERS):
            raise ValueError("weights of another version of the detector")
        detector = cls(*(weights[name] for name in cls.BUFFERS), weights.get("turning"))
        detector.load_state_dict(weights)
        return detector

    def initial(self, count):
        """No objects, for the first step of episodes."""
        tokens, classes = len(self.tokens), len(self.codes)
        known = torch.full((count, tokens), -1)
        place, evidence = torch.zeros(count, tokens, 3), torch.zeros(count, tokens, classes)
        return Tracks(place, known, direction_of(torch.zeros(count, tokens)), evidence)

    def heat_map(self, images):
        """Logits (N, lines, columns) that an object appears in a cell."""
        count = len(images)
        pixels = self.pixels.flatten(0, 1).expand(count, -1, -1)
        seen = sample(images[..., :3], torch.arange(count), pixels)
        seen = seen.unflatten(1, self.pixels.shape[:2]).permute(0, 3, 1, 2)
        return self.peak(self.heat(seen))[:, 0]

    def proposals(self, images):
        """Logits (N, tokens) of the greatest peaks, and their places (N, tokens, 3)."""
        heat = self.heat_map(images)
        peak = heat >= max_pool2d(heat[:, None], 3, 1, 1)[:, 0]
        height, cell = heat.masked_fill(~peak, -9).flatten(1).topk(len(self.tokens))
        return height, self.cells.flatten(0, 1)[cell]

    def features(self, images, proprio, which, places):
        """Features of places (M, 3) in images `which` (M,)."""
        points = places[:, None] + self.around
        position, axes = wrist_view(proprio)
        views = (base_view(), (position[which], axes[which]))
        seen = [
            sample(images[..., 3 * i : 3 * i + 3], which, project(points, view))
            for i, view in enumerate(views)
        ]
        seen = torch.cat(seen, -1).transpose(1, 2).unflatten(2, (PATCH, PATCH))
        tool = 3 * (proprio[which, :3] - places)
        # Along a ray of the base camera the image is the same, but not the height.
        return torch.cat([self.look(seen), places * torch.tensor([3, 3, 20]), tool], -1)

    def judge(self, features, places, known):
        """What is at places (M, 3); known (M,): classes in the step before, or -1.

        -> log-probabilities of classes and of nothing (M, classes + 1), position of the object.
        """
        known = torch.as_tensor(known).expand(len(places))
        before = one_hot(known + 1, len(self.codes) + 1).float()
        hidden = self.read(torch.cat([features, before], -1))
        return self.name(hidden).log_softmax(-1), places + 0.05 * self.shift(hidden)

    @torch.no_grad()
    def update(self, images, proprio, before):
        """Tracks in these images (N, SIDE, SIDE, 6), from those in the images before."""
        height, proposed = self.proposals(images)
        alive = before.known >= 0
        apart = torch.cdist(proposed[..., :2], apparent(before.place, HEIGHT)[..., :2])
        apart = apart.masked_fill(~alive[:, None], 9).amin(-1)
        new = (height > -1.5) & (apart > NEAR)
        proposed[new] = self.judge(*self.seen(images, proprio, new, proposed), -1)[1]
        places = torch.cat([before.place, proposed], 1)
        known = torch.cat([before.known, torch.full_like(before.known, -1)], 1)
        valid = torch.cat([alive, new], 1)
        features, at = self.seen(images, proprio, valid, places)
        named, there = self.judge(features, at, known[valid])
        plain = self.judge(features, at, -1)[0][:, :-1].log_softmax(-1).clamp(min=-5)
        places[valid] = there
        names = named.new_full((*valid.shape, named.shape[-1]), -99.0)
        names[valid] = named
        evidence = torch.cat([KEPT * before.evidence, torch.zeros_like(before.evidence)], 1)
        evidence[valid] += plain
        valid = valid & (names[..., -1] < -0.7)
        tracks = self.assign(places, names[..., :-1], evidence, valid)
        return self.refine(images, proprio, tracks, before.turn)

    def long_ones(self, known):
        """Environment and token (M,) of the objects whose turn is seen."""
        return ((known >= 0) & self.turning[known]).nonzero(as_tuple=True)

    def refine(self, images, proprio, tracks, before):
        """Tracks with places and turns of long objects. before: turns of the step before."""
        if self.refiner is None:
            return tracks
        long = self.long_ones(tracks.known)
        given = images[long[0]], proprio[long[0]], tracks.place[long], before[long]
        tracks.place[long], tracks.turn[long] = self.refiner(*given)
        return tracks

    def seen(self, images, proprio, chosen, places):
        """Features of the chosen (N, P) of places (N, P, 3), and these."""
        places = places[chosen]
        return self.features(images, proprio, chosen.nonzero()[:, 0], places), places

    def assign(self, places, names, evidence, valid):
        """Chooses a candidate for every token: greedily, the most probable first.

        The first candidates are the objects of the step before, which tend to keep their tokens.
        """
        bodies = self.bodies[evidence.argmax(-1)]
        close = (torch.cdist(places, places) < SAME) & (bodies[:, None] == bodies[:, :, None])
        earlier = torch.ones(close.shape[1:]).tril(-1).bool()
        valid = valid & ~(close & earlier & valid[:, None]).any(-1)
        of_body = self.bodies[:, None] == self.tokens
        score = evidence.new_full((*valid.shape, len(self.tokens)), -999.0)
        score[valid] = evidence[valid][..., None].masked_fill(~of_body, -99.0).logsumexp(-2)
        score = score + 2 * torch.eye(*score.shape[1:])
        result = self.initial(len(places))
        rows = torch.arange(len(places))
        for _ in self.tokens:
            best, index = score.flatten(1).max(-1)
            found = best > -50.0
            if not found.any():
                break
            candidate = index.div(len(self.tokens), rounding_mode="floor")
            token = index % len(self.tokens)
            n, candidate, token = rows[found], candidate[found], token[found]
            own = names[n, candidate].masked_fill(~of_body.T[token], -99.0)
            result.place[n, token] = places[n, candidate]
            result.known[n, token] = own.argmax(-1)
            result.evidence[n, token] = evidence[n, candidate]
            score[n, candidate] = -999.0
            score[n, :, token] = -999.0
        return result

    def rows(self, proprio, objects, layout, turn=None):
        """Rows (N, D) of a policy. turn: argument of robot_features."""
        seen = objects.known >= 0
        tokens = self.templates[objects.known]
        tokens[..., layout.place] = objects.place / METRES
        if self.refiner is not None:
            long = self.long_ones(objects.known)
            tokens[..., layout.part["orientation"]][long] = about_vertical(objects.turn[long])
        tokens = tokens * seen[..., None]
        return torch.cat([robot_features(proprio, turn), tokens.flatten(1)], -1)

    def loss(self, images, proprio, now, before):
        """Loss on images that show these objects, and those before in the step before."""
        there = now.known >= 0
        shown = apparent(now.place, HEIGHT)
        few = slice(len(images) // 3)  # the heat map learns fast
        heat = heat_loss(self.heat_map(images[few]), self.cells, shown[few], there[few])
        places, known, target, place = self.examples(proprio, now, before, shown)
        valid = target > -2
        named, found = self.judge(*self.seen(images, proprio, valid, places), known[valid])
        target, place = target[valid], place[valid]
        name = cross_entropy(named, target % named.shape[-1], reduction="none")
        error = smooth_l1_loss(found, place, reduction="none", beta=0.01).sum(-1) * (target >= 0)
        # Frames of a single object count as much as those of many.
        weight = (3 / there.sum(-1).clamp(min=3))[valid.nonzero()[:, 0]]
        loss = heat + (weight * (name + 60 * error)).sum() / weight.sum()
        if self.refiner is not None:
            long = self.long_ones(now.known)
            given = images[long[0]], proprio[long[0]], now.place[long], now.turn[long]
            loss = loss + self.refiner.loss(*given)
        return loss

    def examples(self, proprio, now, before, shown, others=4):
        """Places to look at, and what is to be found there."""
        count, tokens = now.known.shape
        noise = torch.randn(count, tokens, 3)
        scale = torch.rand(count, tokens, 1) * torch.tensor([0.015, 0.015, 0.0])
        proposed = torch.where(torch.rand(count, tokens, 1) < 0.5, shown, now.place) + scale * noise
        cells = self.cells.flatten(0, 1)
        random = cells[torch.randint(len(cells), (count, others))]
        hand = proprio[:, None, :3] + 0.06 * torch.randn(count, others, 3)
        hand[..., 2] = HEIGHT
        places = torch.cat([proposed, random, hand], 1)
        apart = torch.cdist(places[..., :2], shown[..., :2])
        apart, nearest = apart.masked_fill((now.known < 0)[:, None], 9).min(-1)
        target = now.known.gather(1, nearest).masked_fill(apart > NEAR, -1)
        target[:, :tokens].masked_fill_(now.known < 0, -2)
        # Objects of the step before: where the nearest one with the same body is now.
        last = before.place + 0.012 * torch.rand(count, tokens, 1) * noise.flip(0)
        body = self.bodies[before.known][:, :, None] == self.bodies[now.known][:, None]
        absent = ~body | (now.known < 0)[:, None]
        apart, successor = torch.cdist(before.place, now.place).masked_fill(absent, 9).min(-1)
        become = now.known.gather(1, successor).masked_fill(apart > MOVED, -1)
        become = become.masked_fill(before.known < 0, -2)
        wrong = torch.rand(count, tokens) < 0.1
        prior = torch.where(wrong, torch.randint(len(self.codes), wrong.shape), before.known)
        known = torch.cat([torch.full_like(nearest, -1), prior], 1)
        index = torch.cat([nearest, successor], 1)[..., None].expand(-1, -1, 3)
        return Examples(
            places=torch.cat([places, last], 1),
            known=known,
            target=torch.cat([target, become], 1),
            place=now.place.gather(1, index),
        )


def heat_loss(heat, cells, shown, there):
    """Penalty-reduced focal loss of CenterNet."""
    across = torch.exp(-(((shown[..., :1] - cells[:, 0, 0]) / CELL) ** 2))[..., :, None]
    along = torch.exp(-(((shown[..., 1:2] - cells[0, :, 1]) / CELL) ** 2))[..., None, :]
    near = (across * along * there[..., None, None]).amax(1)
    peak = near >= 0.6  # of the nearest cell: at most 0.5 cells away in each direction
    log_p, log_not = nn.functional.logsigmoid(heat), nn.functional.logsigmoid(-heat)
    p = heat.sigmoid()
    found = (1 - p) ** 2 * log_p * peak
    wrong = (1 - near) ** 4 * p**2 * log_not * ~peak
    return -(found + wrong).sum() / peak.sum().clamp(min=1)
