"""Pose refiner: where a long object lies, and along which direction, from both cameras.

It looks at a patch of the table around an object, turned as the object is thought to lie, and tells
by how much that is wrong. So one network serves every direction, and a few rounds find it from
nothing. A peg looks the same after half a turn.
"""

import torch
from torch import nn
from torch.nn.functional import smooth_l1_loss

from engram_learners.images.views import base_view, blended, planes, project, wrist_view
from engram_learners.rotations import angle, direction_of, nearer_half, relative, turned

PATCH, PIXEL = 24, 0.0125  # side of a patch in pixels, and metres of one
ROUNDS = 3  # of an update
REACH = 0.05  # metres of shift per output
FAR, NEAR = 0.015, 0.15  # deviations of examples: metres of the place, radians of the turn


class PoseRefiner(nn.Module):
    def __init__(self):
        super().__init__()
        side = PIXEL * (torch.arange(PATCH) - (PATCH - 1) / 2)
        along, across = torch.meshgrid(side, side, indexing="ij")
        grid = torch.stack([along, across], -1).flatten(0, 1)
        self.register_buffer("grid", grid, persistent=False)
        self.look = nn.Sequential(
            nn.Conv2d(6, 16, 5, 2, 2), nn.ReLU(), nn.Conv2d(16, 24, 3, 2, 1), nn.ReLU()
        )
        self.read = nn.Sequential(nn.Linear(24 * 36 + 6, 64), nn.ReLU(), nn.Linear(64, 4))
        with torch.no_grad():
            self.read[-1].weight *= 0.1
            self.read[-1].bias.copy_(torch.tensor([1.0, 0, 0, 0]))  # no error

    def corrections(self, colors, proprio, places, turn):
        """Cosine and sine (N, 2) of twice the turn that is missing, and shift (N, 2) in metres.

        colors: planes of the images. The shift is along the turn, and across.
        """
        flat = places[:, None, :2] + turned(turn[:, None], self.grid)
        points = torch.cat([flat, places[:, None, 2:].expand(-1, len(self.grid), 1)], -1)
        pixels = [project(points, view) for view in (base_view(), wrist_view(proprio))]
        pixels = [one.unflatten(1, (PATCH, PATCH)) for one in pixels]
        seen = [blended(half, at) for half, at in zip(colors.split(3, 1), pixels)]
        seen = torch.cat(seen, 1)
        tool = proprio[:, :3] - places
        tool = torch.cat([turned(turn, tool[:, :2], back=True), tool[:, 2:]], -1)
        features = [self.look(seen).flatten(1), 3 * tool, 3 * places]
        turn, shift = self.read(torch.cat(features, -1)).split(2, -1)
        return turn / turn.norm(dim=-1, keepdim=True).clamp(min=1e-3), REACH * shift

    def forward(self, images, proprio, places, turn):
        """Places (N, 3) and turns (N, 2), refined: of one object in every image."""
        before, colors = turn, planes(images)
        for _ in range(ROUNDS):
            twice, shift = self.corrections(colors, proprio, places, turn)
            shift = nn.functional.pad(turned(turn, shift), (0, 1))
            places, turn = places + shift, turned(turn, direction_of(angle(twice) / 2))
        return places, nearer_half(turn, before)

    def loss(self, images, proprio, places, turn):
        """Loss on images that show objects at these places, with these turns."""
        count = len(images)
        if count == 0:
            return torch.zeros(())
        away = torch.where(torch.rand(count) < 0.5, NEAR, 2.0) * torch.randn(count)
        start = turned(turn, direction_of(away))
        moved = FAR * torch.randn(count, 2)
        begin = torch.cat([places[:, :2] + moved, places[:, 2:]], -1)
        twice, shift = self.corrections(planes(images), proprio, begin, start)
        missing = relative(direction_of(2 * angle(start)), direction_of(2 * angle(turn)))
        error = relative(twice, missing)
        wrong = 1 - error[..., 0] + smooth_l1_loss(error[..., 1], torch.zeros(count), beta=0.05)
        target = turned(start, -moved, back=True)
        place = smooth_l1_loss(shift, target, reduction="none", beta=0.01).sum(-1)
        return (wrong + 60 * place).mean()
