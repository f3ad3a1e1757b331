"""The classes of tasks, as the original's module of that name has them."""

from __future__ import annotations

from engram.mikasa._torch import torch
from engram.mikasa.agent import Pose
from engram.mikasa.classes import *  # noqa: F403
from engram.mikasa.classes import CLASSES
from engram.mikasa.env import BaseEnv
from engram.mikasa.registration import register_env

__all__ = ["BaseEnv", "Pose", "register_env", "torch", *CLASSES]
