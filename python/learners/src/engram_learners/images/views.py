"""What the two sensor cameras see: projection of points, and pixels at points of the world.

Points are in metres. A view is a camera's position (N, 3) and its axes (N, 3, 3): right, up and
forward, one a row. Both cameras have 90 degrees of field of view.
"""

import numpy as np
import torch
from torch.nn.functional import grid_sample

SIDE = 128  # pixels of an image's side
METRES = 0.5  # positions in tokens are in units of this
ROBOT, TURNING = 8, 5  # numbers of the robot; more where the task is to turn something
# Base camera of all tasks.
POSITION = torch.tensor([[0.3, 0.0, 0.6]])
AXES = torch.tensor([[[0.0, 1.0, 0.0], [-0.780869, 0.0, 0.624695], [-0.624695, 0.0, -0.780869]]])
# Wrist camera, from the tool centre point and along its axes.
MOUNT = torch.tensor([0.0465, -0.02, 0.036 - 0.1034])


def robot_features(proprio, turn=None):
    """Continuous features of the robot (..., ROBOT), from proprio (..., 7).

    turn (..., 1): by which something is to turn, in units of pi; TURNING more features.
    """
    if not torch.is_tensor(proprio):
        proprio = torch.from_numpy(np.array(proprio))
    angles, gripper = proprio[..., 3:6], proprio[..., 6:]
    rotation = [angles.sin(), angles[..., 2:].cos()]
    more = [] if turn is None else [tool_orientation(angles), turn]
    return torch.cat([proprio[..., :3] / METRES, *rotation, gripper / 0.08, *more], -1)


def tool_orientation(angles):
    """Quaternion (..., 4: w, x, y, z) of angles (..., 3) about x, then y, then z.

    Its x is at least 0, so that it has no jump while the hand points down.
    """
    (a, b, c), (p, q, r) = (angles / 2).sin().unbind(-1), (angles / 2).cos().unbind(-1)
    w, x = p * q * r + a * b * c, a * q * r - p * b * c
    y, z = p * b * r + a * q * c, p * q * c - a * b * r
    result = torch.stack([w, x, y, z], -1)
    return torch.where(x[..., None] < 0, -result, result)


def base_view():
    return POSITION, AXES


def wrist_view(proprio):
    """View of the wrist camera, from proprio (N, 7)."""
    sines, cosines = proprio[:, 3:6].sin().unbind(-1), proprio[:, 3:6].cos().unbind(-1)
    (a, b, c), (p, q, r) = sines, cosines
    x = torch.stack([q * r, q * c, -b], -1)
    y = torch.stack([a * b * r - p * c, a * b * c + p * r, a * q], -1)
    z = torch.stack([p * b * r + a * c, p * b * c - a * r, p * q], -1)
    tool = torch.stack([x, y, z], 1)  # its axes, one a row
    return proprio[:, :3] + MOUNT @ tool, torch.stack([y, x, z], 1)


def project(points, view):
    """Pixels (N, P, 2) of points (N, P, 3) from the left and the top; far outside if behind."""
    position, axes = view
    away = (points - position[:, None]) @ axes.transpose(1, 2)
    depth = away[..., 2:]
    across = away[..., :2] / depth.clamp(min=0.01) * torch.tensor([1.0, -1.0])
    return torch.where(depth > 0.01, (across + 1) * SIDE / 2 - 0.5, -SIDE)


def unproject(pixels, height, side=SIDE):
    """Points (..., 3) of a height that the base camera shows at pixels (..., 2) of that many."""
    across = (pixels + 0.5) * 2 / side - 1
    right, up, forward = AXES[0]
    ray = forward + across[..., :1] * right - across[..., 1:] * up
    reach = (height - POSITION[0, 2]) / ray[..., 2:]
    return POSITION[0] + reach * ray


def apparent(points, height):
    """Points (..., 3) of a height that the base camera shows where it shows these."""
    pixels = project(points.reshape(1, -1, 3), base_view()).view(*points.shape[:-1], 2)
    return unproject(pixels, height)


def sample(images, which, pixels):
    """Colours (M, P, 3), -0.5 to 0.5, of images (N, SIDE, SIDE, 3) uint8; 0 outside of them.

    which: the image (M,) of every row of pixels (M, P, 2).
    """
    nearest = pixels.round().long()
    inside = ((nearest >= 0) & (nearest < SIDE)).all(-1, keepdim=True)
    column, line = nearest.clamp(0, SIDE - 1).unbind(-1)
    colors = images.flatten(0, 2)[(which[:, None] * SIDE + line) * SIDE + column]
    return (colors.float() / 255 - 0.5) * inside


def planes(images):
    """Images (N, SIDE, SIDE, 6) uint8 as (N, 6, SIDE, SIDE), -0.5 to 0.5."""
    return images.permute(0, 3, 1, 2).float().div_(255).sub_(0.5)


def blended(colors, pixels):
    """Blended (N, C, H, W) from planes (N, C, SIDE, SIDE) at pixels (N, H, W, 2); 0 outside."""
    return grid_sample(colors, (2 * pixels + 1) / SIDE - 1, align_corners=False)
