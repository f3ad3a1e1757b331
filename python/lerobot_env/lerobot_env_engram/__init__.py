"""Registers the environment type "engram" when LeRobot imports it."""

from __future__ import annotations

from engram.integrations.lerobot import EngramEnvConfig, LeRobotEnv, make_env

__all__ = ["EngramEnvConfig", "LeRobotEnv", "make_env"]
