"""Object detector: a small CNN whose output has the form of the objects observation.

One heat map per appearance in the task: its maximum is the pixel of the object, and the camera's
pose gives the position on the table. Labels are the positions of visible objects in the objects
observation, which are privileged and used in training only. For tasks whose objects all differ in
appearance.
"""

import copy

import numpy as np
import torch
from torch import nn

SIDE = 64  # pixels of an image's side, after downsampling
CELL = 4  # pixels of a cell's side
CELLS = SIDE // CELL
ROBOT = 8
# Base camera of all tasks: position in the world in metres, and axes; 90 degrees field of view.
CAMERA = torch.tensor([0.3, 0.0, 0.6])
RIGHT = torch.tensor([0.0, 1.0, 0.0])
UP = torch.tensor([-0.780869, 0.0, 0.624695])
FORWARD = torch.tensor([-0.624695, 0.0, -0.780869])
METRES = 0.5  # positions in tokens are in units of this


def downsample(rgb):
    """Base camera (N, 64, 64, 3) of pictures (N, 128, 128, 6), uint8 both."""
    parts = np.asarray(rgb)[..., :3].reshape(-1, SIDE, 2, SIDE, 2, 3)
    return torch.from_numpy(parts.mean((-4, -2), dtype=np.float32).astype(np.uint8))


def robot_features(proprio):
    """Continuous features of the robot (..., ROBOT), from proprio (..., 7)."""
    proprio = torch.from_numpy(np.array(proprio))
    angles, gripper = proprio[..., 3:6], proprio[..., 6:]
    rotation = [angles.sin(), angles[..., 2:].cos()]
    return torch.cat([proprio[..., :3] / 0.5, *rotation, gripper / 0.08], -1)


def by_appearance(layout, appearances, tokens):
    """Tokens (..., appearances, width) sorted by appearance, from tokens in any order."""
    mine = layout.pairs(tokens)[..., None, :] == appearances[:, None]
    return mine.float() @ tokens


def detector_layout(layout, appearances):
    """Layout of rows that `robot_features` and an ObjectDetector for these appearances make."""
    result = copy.copy(layout)
    result.agent, result.tcp, result.tokens = ROBOT, slice(0, 3), len(appearances)
    result.arm_speed = slice(0, 0)  # proprio lacks it: a touch needs no rest
    result.tool, result.turn = slice(0, 0), None
    return result


def project(position):
    """Projects positions (..., 3) of tokens to pixels from the image's left and top (..., 2)."""
    away = METRES * position - CAMERA
    across = torch.stack([away @ RIGHT, -(away @ UP)], -1) / (away @ FORWARD)[..., None]
    return (across + 1) * SIDE / 2 - 0.5


def unproject(pixels, height):
    """Inverse of `project` for positions of a known height, as in tokens: (..., 2)."""
    across = (pixels + 0.5) * 2 / SIDE - 1
    ray = FORWARD + across[..., :1] * RIGHT - across[..., 1:] * UP
    reach = (METRES * height - CAMERA[2]) / ray[..., 2]
    return (CAMERA[:2] + reach[..., None] * ray[..., :2]) / METRES


def at(maps, cell):
    """Values (B, appearances, 2) of maps (B, 2, appearances, cells) in a cell (B, appearances)."""
    cell = cell[:, None, :, None].expand(-1, 2, -1, -1)
    return maps.gather(-1, cell)[..., 0].transpose(1, 2)


class ObjectDetector(nn.Module):
    def __init__(self, appearances, templates):
        """appearances: of `ObservationLayout.pairs`. templates: tokens (appearances, width)."""
        super().__init__()
        self.register_buffer("appearances", appearances)
        self.register_buffer("templates", templates)
        layers = [nn.Conv2d(6, 16, 5, 2, 2), nn.ReLU(), nn.Conv2d(16, 24, 3, 2, 1), nn.ReLU()]
        self.maps = nn.Sequential(*layers, nn.Conv2d(24, 3 * len(appearances), 3, 1, 1))
        self.gain = nn.Parameter(torch.ones(len(appearances)))
        self.bias = nn.Parameter(torch.zeros(len(appearances)))

    def forward(self, pictures):
        """Images (B, 64, 64, 3) uint8 -> maps over cells.

        heat (B, appearances, cells): logits of the object's cell; within (B, 2, appearances,
        cells): its offset from a cell in cells; seen (B, appearances): logits of its presence.
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
        """Rows (N, D) of the detected objects. place: slice of a token."""
        heat, within, seen = self(pictures)
        cell = heat.argmax(-1)
        pixels = CELL * (torch.stack([cell % CELLS, cell // CELLS], -1) + at(within, cell))
        tokens = self.templates.repeat(len(seen), 1, 1)
        tokens[..., place][..., :2] = unproject(pixels, self.templates[:, place][:, 2])
        return torch.cat([agent, (tokens * (seen > 0)[..., None]).flatten(1)], -1)

    def loss(self, pictures, tokens, place):
        """Loss on images (B, 64, 64, 3) that show these tokens (B, appearances, width)."""
        heat, within, seen = self(pictures)
        there, pixels = tokens[..., 0], project(tokens[..., place])
        nearest = (pixels / CELL).round().clamp(0, CELLS - 1)
        cell = (nearest[..., 0] + CELLS * nearest[..., 1]).long()
        away = (at(within, cell) - (pixels / CELL - nearest)).abs().sum(-1)
        missed = nn.functional.cross_entropy(heat.transpose(1, 2), cell, reduction="none")
        sure = nn.functional.binary_cross_entropy_with_logits(seen, there)
        return sure + ((missed + away) * there).sum() / there.sum().clamp(min=1)
