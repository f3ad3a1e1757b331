"""The classes of the RL half, as the original's module of that name has them."""

from __future__ import annotations

import numpy as np

from engram.mikasa._torch import torch
from engram.mikasa.agent import Pose
from engram.mikasa.classes import RL_CLASSES
from engram.mikasa.env import BaseEnv
from engram.mikasa.registration import register_env

globals().update(RL_CLASSES)

# Scripts take NumPy and torch from here, too.
__all__ = ["BaseEnv", "Pose", "np", "register_env", "torch", *RL_CLASSES]
