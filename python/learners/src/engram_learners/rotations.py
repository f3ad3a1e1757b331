"""Turns about the vertical, (..., 2): cosine and sine. Orientations are quaternions w, x, y, z."""

import math

import torch


def yaw(quaternion):
    """Cosine and sine (..., 2) of the turn of the x axis about the vertical."""
    w, x, y, z = quaternion.unbind(-1)
    direction = torch.stack([1 - 2 * (y * y + z * z), 2 * (x * y + w * z)], -1)
    return direction / direction.norm(dim=-1, keepdim=True).clamp(min=1e-6)


def about_vertical(direction):
    """Quaternion (..., 4) of a turn about the vertical, by its cosine and sine (..., 2)."""
    half = angle(direction) / 2
    return torch.stack([half.cos(), 0 * half, 0 * half, half.sin()], -1)


def tilt(quaternion):
    """Horizontal rotation vector (..., 2) that turns a tool to point straight down."""
    w, x, y, z = quaternion.unbind(-1)
    return torch.stack([-2 * (y * z - w * x), 2 * (x * z + w * y)], -1)


def relative(first, second):
    """Turn from one direction (..., 2: cosine, sine) to another."""
    (a, b), (c, d) = first.unbind(-1), second.unbind(-1)
    return torch.stack([a * c + b * d, a * d - b * c], -1)


def angle(direction):
    return torch.atan2(direction[..., 1], direction[..., 0])


def direction_of(angles):
    """Cosine and sine (..., 2) of angles (...)."""
    return torch.stack([angles.cos(), angles.sin()], -1)


def nearer_half(direction, before):
    """The direction (..., 2) or its opposite, whichever is nearer to the one before."""
    same = (direction * before).sum(-1, keepdim=True) >= 0
    return torch.where(same, direction, -direction)


def alignments(turn):
    """Least turns (...) after which things look the same as after this one (cosine, sine).

    First for things that look the same after half a turn (a peg), then after a quarter (a cube).
    """
    whole = angle(turn)
    return [torch.remainder(whole + p / 2, p) - p / 2 for p in (math.pi, math.pi / 2)]


def turned(direction, vector, back=False):
    """Vectors (..., 2) turned by a direction (cosine, sine), or back by it."""
    a, b = direction.unbind(-1)
    b = -b if back else b
    x, y = vector.unbind(-1)
    return torch.stack([a * x - b * y, b * x + a * y], -1)
