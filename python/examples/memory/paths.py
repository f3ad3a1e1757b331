"""Paths: what a policy's state keeps of objects that moved by themselves, point by point.

An object moves by itself if it moves while the tool is away from it. Its path stays known when it
is gone. Points are passed when what is at the tool comes near them, in any order.
"""

import torch

MOVED = 0.002  # least motion in a step, 1 mm
AWAY = 0.2  # least distance of the tool from what moves by itself, 0.1 m
HELD = 0.12  # most distance of the tool from what it leads, 60 mm
NEAR = 0.06  # most distance from a point that is passed, 30 mm
AHEAD = 3  # points from the first that is left to another one
MANY = 64  # points left, of which the feature is 1
N_PATHS = 4 + 4 + 3  # features by object: ways to two points, coarse and fine; what is left


def path_size(points):
    """Numbers by object in the state, of paths of this many points."""
    return 3 * points + 1 + 4 if points else 0


def record(path, count, moves, place):
    """Appends the places (T, N, tokens, 2) of the steps in which an object moves to its path.

    path (N, tokens, points, 2), count (N, tokens): before. -> path; count after every step.
    """
    points = path.shape[2]
    counts = count + moves.cumsum(0)
    index = torch.where(moves & (counts <= points), counts - 1, points)  # the last is spare
    index = index.permute(1, 2, 0)[..., None].expand(-1, -1, -1, 2)
    path = torch.cat([path, torch.zeros_like(path[:, :, :1])], 2)
    path = path.scatter(2, index, place.permute(1, 2, 0, 3))[:, :, :points]
    return path, counts.clamp(max=points)


def follow(path, counts, passed, led, leads):
    """Which points of every path have been passed after every step (T, N, tokens, points).

    passed (N, tokens, points): before. led (T, N, 2): what the tool leads, if it leads anything.
    """
    near = (path - led[:, :, None, None]).norm(dim=-1) < NEAR
    near &= leads[..., None, None] & in_use(counts, path.shape[2])
    return (near | passed).cummax(0).values


def in_use(counts, points):
    return torch.arange(points, device=counts.device) < counts[..., None]


@torch.no_grad()
def paths(layout, rows, kept, points):
    """Continues from what is kept (N, tokens, path_size); None begins an episode.

    -> features by object (T, N, tokens, N_PATHS), what is kept.
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
    path, counts = record(path.unflatten(-1, (points, 2)), count[..., 0].long(), moves, flat)
    distance, nearest = distance.masked_fill(seen[..., 0] == 0, torch.inf).min(-1)
    led = flat.take_along_dim(nearest[..., None, None], 2)[:, :, 0]
    passed = follow(path, counts, passed > 0, led, distance < HELD)
    kept = [path.flatten(2), passed[-1], counts[-1, ..., None], now[-1]]
    features = features_of(path, counts, passed, flat) * seen
    return features, torch.cat([part.float() for part in kept], -1)


def features_of(path, counts, passed, place):
    """Ways from every object to points that are left of the longest path, and what is left."""
    which = counts.argmax(-1)[..., None]
    path = path.expand(len(counts), *path.shape).take_along_dim(which[..., None, None], 2)[:, :, 0]
    count = counts.take_along_dim(which, 2)
    left = in_use(counts, passed.shape[-1]) & ~passed
    left = left.take_along_dim(which[..., None], 2)[:, :, 0].float()
    first = left.argmax(-1, keepdim=True)
    ways = []
    for ahead in (0, AHEAD):
        index = torch.minimum(first + ahead, count - 1).clamp(min=0)[..., None]
        ways.append(path.take_along_dim(index, 2) - place)
    known = (count > 0)[..., None].float()
    ways = torch.cat(ways, -1) * known
    left = left.sum(-1, keepdim=True)
    remains = torch.stack([count > 0, left > 0, left / MANY], -1)
    return torch.cat([5 * ways, (20 * ways).tanh(), remains.expand(*ways.shape[:-1], 3)], -1)
