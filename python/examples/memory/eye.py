"""Sees objects in pictures: a small CNN whose output has the form of the objects observation.

One heat map per look that the task has; where a map peaks an object of that look stands. It is
taught with the places of what is in sight, as the objects observation tells them: privileged, in
training only. For tasks whose objects all look different.
"""

import copy

import numpy as np
import torch
from torch import nn

SIDE = 64  # pixels of a picture's side, after halving
ROBOT = 8


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
        self.place = nn.Linear(5, 2)

    def forward(self, pictures):
        """Pictures (B, 64, 64, 3) uint8 -> what is in sight.

        How surely each look is seen, as logits (B, looks); its place (B, looks, 2), as in tokens.
        """
        color = pictures.permute(0, 3, 1, 2).float() / 255
        tint = color / (color.sum(1, keepdim=True) + 0.1)
        tint = tint - tint.mean((-1, -2), keepdim=True)
        maps = self.maps(torch.cat([color - 0.5, 5 * tint], 1)).unflatten(1, (3, -1))
        heat = maps[:, 0].flatten(2)
        share = (10 * heat).softmax(-1).unflatten(-1, maps.shape[-2:])
        steps = torch.linspace(-1, 1, maps.shape[-1])
        cell = torch.stack([(share.sum(-2) * steps).sum(-1), (share.sum(-1) * steps).sum(-1)], -1)
        within = (share[:, None] * maps[:, 1:]).sum((-2, -1)).transpose(1, 2)
        u, v = (cell + within).unbind(-1)
        place = self.place(torch.stack([u, v, u * u, u * v, v * v], -1))
        return heat.amax(-1) * self.gain + self.bias, place

    def groups(self):
        fast = [self.gain, self.bias, *self.place.parameters()]
        return [{"params": self.maps.parameters(), "lr": 3e-3}, {"params": fast, "lr": 2e-2}]

    @torch.no_grad()
    def rows(self, pictures, agent, place):
        """Rows (N, D) of what is in sight. place: that part of a token."""
        seen, where = self(pictures)
        tokens = self.templates.repeat(len(seen), 1, 1)
        tokens[..., place.start : place.start + 2] = where
        return torch.cat([agent, (tokens * (seen > 0)[..., None]).flatten(1)], -1)

    def loss(self, pictures, tokens, place):
        """Of pictures (B, 64, 64, 3) that show these tokens (B, looks, width)."""
        seen, where = self(pictures)
        there = tokens[..., 0]
        sure = nn.functional.binary_cross_entropy_with_logits(seen, there)
        away = (where - tokens[..., place.start : place.start + 2]).abs().sum(-1) * there
        return sure + 2 * away.sum() / there.sum().clamp(min=1)
