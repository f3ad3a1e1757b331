"""The classes of the RL half, as the original's module of that name has them."""

from __future__ import annotations

from engram.mikasa._torch import torch
from engram.mikasa.agent import Pose
from engram.mikasa.classes import RL_CLASSES
from engram.mikasa.env import BaseEnv
from engram.mikasa.registration import register_env

globals().update(RL_CLASSES)

__all__ = ["BaseEnv", "Pose", "register_env", "torch", *RL_CLASSES]
