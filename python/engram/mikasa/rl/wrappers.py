"""The RL half's wrappers. Those of observations and actions are the VLA half's; overlays differ.

Letters have no outline, and the reward is drawn whatever MIKASA_DISABLE_REWARD_OVERLAY says.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from engram.mikasa import drawing, overlays
from engram.mikasa.wrappers import (
    CameraShutdownWrapper,
    InitialZeroActionWrapper,
    StateOnlyTensorToDictWrapper,
)

__all__ = [
    "CameraShutdownWrapper",
    "DebugRewardWrapper",
    "InitialZeroActionWrapper",
    "MemoryCapacityInfoWrapper",
    "RememberColorInfoWrapper",
    "RememberShapeAndColorInfoWrapper",
    "RememberShapeInfoWrapper",
    "RenderRewardInfoWrapper",
    "RenderStepInfoWrapper",
    "RotateRenderAngleInfoWrapper",
    "ShellGameRenderCupInfoWrapper",
    "StateOnlyTensorToDictWrapper",
]

_PLACE = (10, 60)  # of what the episode asks for


class RenderStepInfoWrapper(overlays.RenderStepInfoWrapper):
    """The number of steps."""

    _outlined = False


class RenderRewardInfoWrapper(overlays.OverlayWrapper):
    """The reward."""

    _outlined = False

    def draw(self, image: np.ndarray, index: int) -> None:
        """See the class."""
        reward = 0.0 if self.reward is None else float(self.reward[index])
        self._put_text(image, f"Reward: {reward:.3f}", (10, 120))


class DebugRewardWrapper(overlays.OverlayWrapper):
    """The reward's terms, a line each."""

    _outlined = False

    def draw(self, image: np.ndarray, index: int) -> None:
        """See the class."""
        for i, (name, values) in enumerate((self.info.get("reward_dict") or {}).items()):
            text = f"{name}: {float(values[index]):.3f}"
            self._put_text(image, text, (10, 170 + 20 * i), 0.5)


class ShellGameRenderCupInfoWrapper(overlays.ShellGameRenderCupInfoWrapper):
    """The correct cup."""

    _outlined = False


class RememberColorInfoWrapper(overlays.ColorWrapper):
    """The colour to touch, by name."""

    _outlined = False

    def draw(self, image: np.ndarray, index: int) -> None:
        """See the class."""
        number = self._info_value("oracle_info", index)
        if number is not None:
            self._put_text(image, f"Target: {self._color_name(number)}", _PLACE)


class RememberShapeInfoWrapper(overlays.RememberShapeInfoWrapper):
    """The shape to touch."""

    _outlined = False


class RememberShapeAndColorInfoWrapper(overlays.ColorWrapper):
    """The colour's name in its colour, and the shape."""

    _outlined = False

    def draw(self, image: np.ndarray, index: int) -> None:
        """See the class."""
        answer = self._info_value("oracle_info", index)
        self._put_text(image, "Target:", _PLACE)
        if answer is None:
            return
        base: Any = self.unwrapped
        shape, color = answer
        name = self._color_name(color)
        red, green, blue = (round(float(part)) for part in self._color(color)[:3])
        self._put_text(image, name, (130, 60), color=(red, green, blue))
        x = 130 + drawing.text_width(f"{name} ")
        self._put_text(image, overlays.named(base.BASE_SHAPES, shape), (x, 60))


class MemoryCapacityInfoWrapper(overlays.MemoryCapacityInfoWrapper):
    """The colours to touch; touched ones have a white border, if infos have them."""

    _outlined = False


class RotateRenderAngleInfoWrapper(overlays.OverlayWrapper):
    """Target and present angle in degrees."""

    _outlined = False

    def draw(self, image: np.ndarray, index: int) -> None:
        """See the class."""
        lines = (("Target :", "task_cue", 60), ("Current:", "relative_angle", 90))
        for text, name, height in lines:
            angle = self._info_value(name, index)
            if angle is not None:
                degrees = round(math.degrees(angle), 2)
                self._put_text(image, f"{text} {degrees} deg", (10, height))
