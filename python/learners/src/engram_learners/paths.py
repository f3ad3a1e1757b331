"""Paths: what a policy's state keeps of objects that moved by themselves, point by point.

An object moves by itself if it moves while the tool is away from it. Its path stays known when it
is gone. It consists of lines: where one closes or the object jumps, another one begins. What is at
the tool passes one line after the other: the points of a line in any order, its end at last.
"""

from typing import NamedTuple

import torch
from torch import nn

MOVED = 0.002  # least motion in a step, 1 mm
AWAY = 0.2  # least distance of the tool from what moves by itself, 0.1 m
HELD = 0.12  # most distance of the tool from what it leads, 60 mm
NEAR = 0.07  # most distance from a point that is passed, 35 mm
GAP = 4  # most points in a row that count as passed once the tool has gone on
ON = 12  # points, or to the line's end
END = 8  # points before a line's end: what is left of them counts as passed at the end
JUMP = 0.08  # least distance between points that are of two lines, 40 mm
CLOSED = 1.5  # most distance of a closed line's end from its first point, in steps
LOOP = 8  # least points of a closed line
AHEAD = 3  # points from the first that is left to another one
AROUND = 0.2  # most way from the first point that is left to the nearest one, 100 mm
LOOKAHEAD = 0.07  # way from the nearest point to the one that is pursued, 35 mm
MANY = 64  # points left, of which the feature is 1
N_PATH_BY_OBJECT = 6 + 6  # features by object: vectors to three points, coarse and fine
N_PATH_GLOBAL = 4  # features of what remains


def path_size(points):
    """Numbers by object in the state, of paths of this many points."""
    return 3 * points + 1 + 4 if points else 0


def record(path, count, moves, place, earlier):
    """Appends the places (T, N, tokens, 2) of the steps in which an object moves to its path.

    It begins with the place before the first motion.
    path (N, tokens, points, 2), count (N, tokens): before. earlier: places a step before.
    -> path; count after every step.
    """
    points = path.shape[2]
    moved = count + moves.cumsum(0)
    counts = moved + ((count == 0) & (moved > 0))
    begins = moves & (count == 0) & (moved == 1)
    origin = (earlier * begins[..., None]).sum(0)
    origin = torch.where(begins.any(0)[..., None], origin, path[:, :, 0])
    path = torch.cat([origin[:, :, None], path[:, :, 1:]], 2)
    index = torch.where(moves & (counts <= points), counts - 1, points)  # the last is spare
    index = index.permute(1, 2, 0)[..., None].expand(-1, -1, -1, 2)
    path = torch.cat([path, torch.zeros_like(path[:, :, :1])], 2)
    path = path.scatter(2, index, place.permute(1, 2, 0, 3))[:, :, :points]
    return path, counts.clamp(max=points)


class Lines(NamedTuple):
    """By point (N, tokens, points): its line, whether it ends one, the way to it, and its place.

    Ways are those along the lines from the first point; between lines they are endless. The place
    of a closed line's end is its first point.
    """

    number: torch.Tensor
    ends: torch.Tensor
    way: torch.Tensor
    place: torch.Tensor


def lines_of(path, count):
    points = path.shape[2]
    order = torch.arange(points, device=path.device)
    steps = nn.functional.pad((path[:, :, 1:] - path[:, :, :-1]).norm(dim=-1), (1, 0))
    jumps = nn.functional.pad(steps[..., 1:] > JUMP, (0, 1))
    used, ends, place = in_use(count, points), order == count[..., None] - 1, path
    begin = torch.zeros_like(count)[..., None]
    while (begin < count[..., None]).any():  # once per line
        first = path.take_along_dim(begin.clamp(max=points - 1)[..., None], 2)
        loop = (order >= begin + LOOP - 1) & ((path - first).norm(dim=-1) < CLOSED * steps)
        is_end = used & (order >= begin) & (loop | jumps | ends)
        end = torch.where(is_end, order, points).amin(-1, keepdim=True)
        now = order == end
        ends = ends | now
        place = torch.where((now & loop)[..., None], first, place)
        begin = end + 1
    begins = nn.functional.pad(ends[..., :-1], (1, 0))
    way = torch.where(begins, 1e3, steps).cumsum(-1)
    return Lines(begins.cumsum(-1), ends, way, place)


def follow(lines, counts, passed, led, leads):
    """Which points of every path have been passed after every step (T, N, tokens, points).

    passed (N, tokens, points): before. led (T, N, 2): what the tool leads, if any (T, N).
    """
    near = (lines.place - led[:, :, None, None]).norm(dim=-1) < NEAR
    near &= leads[..., None, None] & in_use(counts, passed.shape[-1])
    result = []
    for near_now in near:
        passed = pass_points(lines, near_now, passed)
        result.append(passed)
    return torch.stack(result)


def pass_points(lines, near, passed):
    """The points (N, tokens, points) that are passed after a step.

    Those that what is led has missed, at a corner, are left for a while: it may come back to them.
    """
    order = torch.arange(passed.shape[-1], device=passed.device)
    first = (~passed).int().argmax(-1, keepdim=True)
    now = lines.number == lines.number.gather(-1, first)
    passed = passed | (near & now & ~lines.ends)
    before = torch.where(passed, order, -1).cummax(-1).values
    behind = torch.where(passed, order, 2 * len(order)).flip(-1).cummin(-1).values.flip(-1)
    last = torch.where(lines.ends & now, order, -1).amax(-1, keepdim=True)
    at_end = (near & (order == last)).any(-1, keepdim=True)
    reached = torch.where(near & now, order, -1).amax(-1, keepdim=True)
    gone_on = (reached - behind >= ON) | at_end
    missed = (behind - before <= GAP + 1) & gone_on
    missed |= (last - before <= END + 1) & at_end
    begun = (before >= 0) & (lines.number == lines.number.gather(-1, before.clamp(min=0)))
    passed = passed | (missed & now & begun & (order < last))
    first = (~passed).int().argmax(-1, keepdim=True)
    return passed | (near & (order == first) & (order == last))


def in_use(counts, points):
    return torch.arange(points, device=counts.device) < counts[..., None]


class PathFeatures(NamedTuple):
    """Features by object (T, N, tokens, N_PATH_BY_OBJECT), and of what remains of the path.

    remaining (T, N, N_PATH_GLOBAL). kept (N, tokens, path_size): what the next call continues from.
    """

    by_object: torch.Tensor
    remaining: torch.Tensor
    kept: torch.Tensor


@torch.no_grad()
def paths(layout, rows, kept, points):
    """Continues from what is kept (N, tokens, path_size); None begins an episode.

    -> PathFeatures.
    """
    agent, tokens = layout.split(rows)
    if kept is None:
        kept = tokens.new_zeros(*tokens.shape[1:3], path_size(points))
    path, passed, count, before = kept.split([2 * points, points, 1, 4], -1)
    seen, place = tokens[..., :1], tokens[..., layout.place]
    distance = (place - agent[..., None, layout.tcp]).norm(dim=-1)
    now = torch.cat([seen, place], -1)
    earlier = torch.cat([before[None], now[:-1]])
    moves = (seen * earlier[..., :1])[..., 0] > 0
    moves &= ((place - earlier[..., 1:]).norm(dim=-1) > MOVED) & (distance > AWAY)
    flat = place[..., :2]
    path, count = path.unflatten(-1, (points, 2)), count[..., 0].long()
    path, counts = record(path, count, moves, flat, earlier[..., 1:3])
    distance, nearest = distance.masked_fill(seen[..., 0] == 0, torch.inf).min(-1)
    led = flat.take_along_dim(nearest[..., None, None], 2)[:, :, 0]
    lines = lines_of(path, counts[-1])
    passed = follow(lines, counts, passed > 0, led, distance < HELD)
    kept = [path.flatten(2), passed[-1], counts[-1, ..., None], now[-1]]
    by_object, remaining = features_of(lines, counts, passed, flat)
    kept = torch.cat([part.float() for part in kept], -1)
    return PathFeatures(by_object * seen, remaining, kept)


def features_of(lines, counts, passed, place):
    """Vectors from every object to points of the longest path, and what remains of it."""
    which = counts.argmax(-1)[..., None]
    count = counts.take_along_dim(which, 2)
    left = in_use(counts, passed.shape[-1]) & ~passed
    left = left.take_along_dim(which[..., None], 2)[:, :, 0].float()
    first = left.argmax(-1, keepdim=True)
    steps, path, way = len(counts), lines.place, lines.way
    path = path.expand(steps, *path.shape).take_along_dim(which[..., None, None], 2)[:, :, 0]
    way = way.expand(steps, *way.shape).take_along_dim(which[..., None], 2)[:, :, 0]
    pursued = pursue(path, way, count, first, place)
    points = [(first + ahead).expand_as(pursued) for ahead in (0, AHEAD)] + [pursued]
    to_points = []
    for index in points:
        index = torch.minimum(index, count - 1).clamp(min=0)[..., None]
        to_points.append(path.take_along_dim(index, 2) - place)
    vectors = torch.cat(to_points, -1) * (count > 0)[..., None]
    count_left = left.sum(-1, keepdim=True)
    to_begin = way.gather(-1, first) - way.gather(-1, (first - 1).clamp(min=0))
    begins = (first == 0) | (to_begin > 1)
    some = count_left > 0
    remaining = torch.cat([count > 0, some, count_left / MANY, begins & some], -1)
    return torch.cat([5 * vectors, (20 * vectors).tanh()], -1), remaining


def pursue(path, way, count, first, place):
    """The point (T, N, tokens) ahead of the one of the path that is nearest to each object."""
    distance = (path[:, :, None] - place[..., None, :]).norm(dim=-1)
    used = in_use(count[..., 0], path.shape[2])
    around = used & ((way - way.gather(-1, first)).abs() < AROUND)
    nearest = distance.masked_fill(~around[:, :, None], torch.inf).argmin(-1)
    most = way.gather(-1, nearest) + LOOKAHEAD
    return torch.searchsorted(way, most, right=True) - 1
