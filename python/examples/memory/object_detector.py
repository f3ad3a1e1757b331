"""Sees objects in pictures: a small CNN whose output has the form of the objects observation.

One heat map per look that the task has; where a map peaks an object of that look stands, and the
camera's pose says where on the table that is. It is taught with the places of what is in sight, as
the objects observation tells them: privileged, in training only. For tasks whose objects all look
different.
"""

import copy

import numpy as np
import torch
from torch import nn

SIDE = 64  # pixels of a picture's side, after halving
CELL = 4  # pixels of a map's cell
CELLS = SIDE // CELL
ROBOT = 8
# The base camera of all tasks, metres in the world: where it is, and its axes. It sees 90 degrees.
CAMERA = torch.tensor([0.3, 0.0, 0.6])
RIGHT = torch.tensor([0.0, 1.0, 0.0])
UP = torch.tensor([-0.780869, 0.0, 0.624695])
FORWARD = torch.tensor([-0.624695, 0.0, -0.780869])
METRES = 0.5  # positions in tokens are in units of this


def halved(rgb):
    """Base camera (N, 64, 64, 3) of pictures (N, 128, 128, 6), uint8 both."""
    parts = np.asarray(rgb)[..., :3].reshape(-1, SIDE, 2, SIDE, 2, 3)
    return torch.from_numpy(parts.mean((-4, -2), dtype=np.float32).astype(np.uint8))


def robot(proprio):
    """What a policy hears of the robot (..., ROBOT), from proprio (..., 7), without its jumps."""
    proprio = torch.from_numpy(np.array(proprio))
    angles, gripper = proprio[..., 3:6], proprio[..., 6:]
    turned = [angles.sin(), angles[..., 2:].cos()]
    return torch.cat([proprio[..., :3] / 0.5, *turned, gripper / 0.08], -1)


def by_look(sight, looks, tokens):
    """Tokens (..., looks, width) sorted by look, from tokens in any order."""
    mine = sight.pairs(tokens)[..., None, :] == looks[:, None]
    return mine.float() @ tokens


def of_pictures(sight, looks):
    """The Sight of rows that `robot` and an Eye for these looks make."""
    seen = copy.copy(sight)
    seen.agent, seen.tcp, seen.tokens = ROBOT, slice(0, 3), len(looks)
    seen.arm_speed = slice(0, 0)  # proprio does not tell it: to pass by is to touch
    return seen


def spot(place):
    """Where in the picture places (..., 3) of tokens are: pixels from its left and top (..., 2)."""
    away = METRES * place - CAMERA
    across = torch.stack([away @ RIGHT, -(away @ UP)], -1) / (away @ FORWARD)[..., None]
    return (across + 1) * SIDE / 2 - 0.5


def place_at(pixels, height):
    """Inverse of `spot`, for places of a known height, as in tokens: (..., 2)."""
    across = (pixels + 0.5) * 2 / SIDE - 1
    ray = FORWARD + across[..., :1] * RIGHT - across[..., 1:] * UP
    reach = (METRES * height - CAMERA[2]) / ray[..., 2]
    return (CAMERA[:2] + reach[..., None] * ray[..., :2]) / METRES


def at(maps, cell):
    """Values (B, looks, 2) of maps (B, 2, looks, cells) in a cell (B, looks)."""
    cell = cell[:, None, :, None].expand(-1, 2, -1, -1)
    return maps.gather(-1, cell)[..., 0].transpose(1, 2)


class Eye(nn.Module):
    def __init__(self, looks, templates):
        """looks: numbers as of `Sight.pairs`. templates (looks, width): a token of each."""
        super().__init__()
        self.register_buffer("looks", looks)
        self.register_buffer("templates", templates)
        layers = [nn.Conv2d(6, 16, 5, 2, 2), nn.ReLU(), nn.Conv2d(16, 24, 3, 2, 1), nn.ReLU()]
        self.maps = nn.Sequential(*layers, nn.Conv2d(24, 3 * len(looks), 3, 1, 1))
        self.gain = nn.Parameter(torch.ones(len(looks)))
        self.bias = nn.Parameter(torch.zeros(len(looks)))

    def forward(self, pictures):
        """Pictures (B, 64, 64, 3) uint8 -> maps over cells.

        heat (B, looks, cells): highest where an object of that look is; within (B, 2, looks,
        cells): how many cells right and down of a cell's pixel it is; seen (B, looks): how surely
        it is in sight, as logits.
        """
        color = pictures.permute(0, 3, 1, 2).float() / 255
        tint = color / (color.sum(1, keepdim=True) + 0.1)
        tint = tint - tint.mean((-1, -2), keepdim=True)
        maps = self.maps(torch.cat([color - 0.5, 5 * tint], 1)).unflatten(1, (3, -1)).flatten(3)
        heat, within = maps[:, 0], maps[:, 1:]
        return heat, within, heat.amax(-1) * self.gain + self.bias

    def groups(self):
        fast = [self.gain, self.bias]
        return [{"params": self.maps.parameters(), "lr": 3e-3}, {"params": fast, "lr": 2e-2}]

    @torch.no_grad()
    def rows(self, pictures, agent, place):
        """Rows (N, D) of what is in sight. place: that part of a token."""
        heat, within, seen = self(pictures)
        cell = heat.argmax(-1)
        pixels = CELL * (torch.stack([cell % CELLS, cell // CELLS], -1) + at(within, cell))
        tokens = self.templates.repeat(len(seen), 1, 1)
        tokens[..., place][..., :2] = place_at(pixels, self.templates[:, place][:, 2])
        return torch.cat([agent, (tokens * (seen > 0)[..., None]).flatten(1)], -1)

    def loss(self, pictures, tokens, place):
        """Of pictures (B, 64, 64, 3) that show these tokens (B, looks, width)."""
        heat, within, seen = self(pictures)
        there, pixels = tokens[..., 0], spot(tokens[..., place])
        nearest = (pixels / CELL).round().clamp(0, CELLS - 1)
        cell = (nearest[..., 0] + CELLS * nearest[..., 1]).long()
        away = (at(within, cell) - (pixels / CELL - nearest)).abs().sum(-1)
        missed = nn.functional.cross_entropy(heat.transpose(1, 2), cell, reduction="none")
        sure = nn.functional.binary_cross_entropy_with_logits(seen, there)
        return sure + ((missed + away) * there).sum() / there.sum().clamp(min=1)
