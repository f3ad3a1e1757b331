"""Wrappers of batches for training: each by itself, and off unless it is used.

    env = engram.make_vec(id, 64, preset="train", autoreset_mode="SAME_STEP")

``train`` says what the preset consists of. Evaluations know nothing of wrappers; a policy brings
them along as a ``WrappedPolicy``.
"""

from __future__ import annotations

from engram.wrappers.actions import ScaleActions, SmoothActions
from engram.wrappers.base import BENCHMARK_REWARD, Wrapper
from engram.wrappers.observations import ObjectRows, ScaleState, TimeLeft
from engram.wrappers.policy import WrappedPolicy
from engram.wrappers.preset import train
from engram.wrappers.rewards import HeldReward, PotentialReward
from engram.wrappers.starts import EqualStarts

__all__ = [
    "BENCHMARK_REWARD",
    "EqualStarts",
    "HeldReward",
    "ObjectRows",
    "PotentialReward",
    "ScaleActions",
    "ScaleState",
    "SmoothActions",
    "TimeLeft",
    "WrappedPolicy",
    "Wrapper",
    "train",
]
