"""Overlays over the images of ``render``; observations are not changed."""

from __future__ import annotations

import math
import os
from typing import Any

import gymnasium as gym
import numpy as np

from engram.mikasa import drawing
from engram.mikasa._base_wrappers import Wrapper
from engram.mikasa._torch import torch

_WHITE = (255, 255, 255)
_BLACK = (0, 0, 0)
_GREEN = (80, 220, 80)
_RED = (230, 70, 70)
_YELLOW = (240, 210, 60)
_YES = ("1", "true", "yes", "y", "on")

_COLOR_NAMES = {(255, 0, 0): "Red", (0, 255, 0): "Green", (0, 0, 255): "Blue"}
_CUPS = ("Left", "Center", "Right")
_SHAPES = (
    "cube",
    "sphere",
    "cylinder",
    "cross",
    "torus",
    "star",
    "pyramide",
    "t_shape",
    "crescent",
)
_CONTOURS = ("Circle", "Square", "Triangle")


class OverlayWrapper(Wrapper):
    """Draws values of the last step over each environment's image."""

    _passes_parts = True
    _outlined = True  # letters, in black

    def __init__(self, env: gym.Env[Any, Any]) -> None:
        super().__init__(env)
        self.info: dict[str, Any] = {}
        self.reward: Any = None

    def reset(self, **kwargs: Any) -> tuple[Any, dict[str, Any]]:
        """See the wrapped environment."""
        observation, self.info = self.env.reset(**kwargs)
        self.reward = None
        return observation, self.info

    def step(self, action: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """See the wrapped environment."""
        result = self.env.step(action)
        self.reward, self.info = result[1], result[4]
        return result

    def render(self) -> Any:
        """The images as an array, uint8 (B, height, width, 3)."""
        images: Any = self.env.render()
        if isinstance(images, torch.Tensor):
            images = images.numpy()
        images = np.array(images)
        for i, image in enumerate(images):
            self.draw(image, i)
        return images

    def draw(self, image: np.ndarray, index: int) -> None:
        """Draws over one environment's image."""
        raise NotImplementedError

    def _put_text(
        self,
        image: np.ndarray,
        text: str,
        place: tuple[int, int],
        scale: float = 1.0,
        color: drawing.Color = _WHITE,
    ) -> None:
        drawing.put_text(image, text, place, scale, color, outlined=self._outlined)

    def _info_value(self, name: str, index: int) -> Any:
        """A value of the info as a plain number or list; None where there is none."""
        value = self.info.get(name)
        if value is None:
            return None
        return value[index].tolist() if isinstance(value, torch.Tensor) else value

    def _attribute(self, name: str, index: int) -> Any:
        """An attribute of the environment as a plain number or list."""
        value = getattr(self.unwrapped, name, None)
        return value[index].tolist() if isinstance(value, torch.Tensor) else value


class RenderStepInfoWrapper(OverlayWrapper):
    """The number of steps."""

    def draw(self, image: np.ndarray, index: int) -> None:
        """See the class."""
        self._put_text(image, f"Step: {self._info_value('elapsed_steps', index) or 0}", (10, 30))


class RenderRewardInfoWrapper(OverlayWrapper):
    """The reward; not if MIKASA_DISABLE_REWARD_OVERLAY is 1, true, yes, y or on."""

    def draw(self, image: np.ndarray, index: int) -> None:
        """See the class."""
        if os.environ.get("MIKASA_DISABLE_REWARD_OVERLAY", "").strip().lower() in _YES:
            return
        reward = 0.0 if self.reward is None else float(self.reward[index])
        self._put_text(image, f"Reward: {reward:.3f}", (10, 90))


class DebugRewardWrapper(OverlayWrapper):
    """The reward's terms, a line each; not if MIKASA_DISABLE_REWARD_OVERLAY is 1."""

    def draw(self, image: np.ndarray, index: int) -> None:
        """See the class."""
        if os.environ.get("MIKASA_DISABLE_REWARD_OVERLAY") == "1":
            return
        terms = self.info.get("reward_dict") or {}
        for i, (name, values) in enumerate(terms.items()):
            text = f"{name}: {float(values[index]):.3f}"
            self._put_text(image, text, (10, 170 + 20 * i), 0.5)


class ShellGameRenderCupInfoWrapper(OverlayWrapper):
    """The correct cup."""

    def draw(self, image: np.ndarray, index: int) -> None:
        """See the class."""
        cup = self._info_value("oracle_info", index)
        known = isinstance(cup, int) and 0 <= cup < len(_CUPS)
        text = f"Target: {_CUPS[cup]}" if known else f"Oracle: {cup}"
        self._put_text(image, text, (10, 60))


class ColorWrapper(OverlayWrapper):
    """Knows the colours of the task."""

    def _color(self, number: int) -> Any:
        """A colour of the task, 0 to 255."""
        base: Any = self.unwrapped
        mapping = getattr(base, "COLOR_MAPPING", None)
        if mapping is not None:
            return mapping[number][1]
        return 255 * np.asarray(base.COLOR_PALETTE[number])

    def _color_name(self, number: int) -> str:
        """The name of a colour; of one of a palette that of the usual three, or its number."""
        base: Any = self.unwrapped
        mapping = getattr(base, "COLOR_MAPPING", None)
        if mapping is not None:
            return str(mapping[number][0])
        rgb = tuple(np.rint(self._color(number)[:3]).astype(int).tolist())
        return _COLOR_NAMES.get(rgb, f"Color {number}")


class RememberColorInfoWrapper(ColorWrapper):
    """The colour to touch."""

    def draw(self, image: np.ndarray, index: int) -> None:
        """See the class."""
        self._put_text(image, "Target:", (10, 60))
        number = self._info_value("oracle_info", index)
        if number is not None:
            drawing.swatch(image, 130, 38, 22, self._color(number), _WHITE)


class RememberShapeInfoWrapper(OverlayWrapper):
    """The shape to touch."""

    def draw(self, image: np.ndarray, index: int) -> None:
        """See the class."""
        number = self._info_value("oracle_info", index)
        mapping = getattr(self.unwrapped, "SHAPE_MAPPING", dict(enumerate(_SHAPES)))
        self._put_text(image, f"Target: {named(mapping, number)}", (10, 60))


class RememberShapeAndColorInfoWrapper(ColorWrapper):
    """Shape and colour to touch."""

    def draw(self, image: np.ndarray, index: int) -> None:
        """See the class."""
        self._put_text(image, "Target:", (10, 60))
        answer = self._info_value("oracle_info", index)
        if answer is None:
            return
        shape, color = answer
        drawing.swatch(image, 130, 38, 22, self._color(color), _WHITE)
        base: Any = self.unwrapped
        self._put_text(image, named(base.BASE_SHAPES, shape), (165, 60))


class MemoryCapacityInfoWrapper(ColorWrapper):
    """The colours to touch; touched ones have a white border, if infos have them."""

    def draw(self, image: np.ndarray, index: int) -> None:
        """See the class."""
        self._put_text(image, "Target: ", (10, 60))
        touched = self._attribute("touched_cubes", index)
        for i, number in enumerate(self._info_value("oracle_info", index) or ()):
            border = _WHITE if touched is not None and touched[number] else _BLACK
            drawing.swatch(image, 130 + 25 * i, 45, 15, self._color(number), border)


class RotateRenderAngleInfoWrapper(OverlayWrapper):
    """Target and present angle in degrees."""

    def draw(self, image: np.ndarray, index: int) -> None:
        """See the class."""
        lines = (("Target :", "task_cue", 60), ("Current:", "relative_angle", 120))
        for text, name, height in lines:
            angle = self._info_value(name, index)
            if angle is not None:
                degrees = round(math.degrees(angle), 2)
                self._put_text(image, f"{text} {degrees} deg", (10, height))


class RenderPressProgressInfoWrapper(OverlayWrapper):
    """Presses: all, those that count, the required ones."""

    def draw(self, image: np.ndarray, index: int) -> None:
        """See the class."""
        names = ("raw_press_count", "press_count", "target_blinks")
        counts = "/".join(str(self._info_value(name, index)) for name in names)
        self._put_text(image, f"Press raw/conf: {counts}", (10, 120), 0.8)


class RenderWorkingBatteriesInfoWrapper(OverlayWrapper):
    """Working batteries: found, and all of them."""

    def draw(self, image: np.ndarray, index: int) -> None:
        """See the class."""
        names = ("found_working_count", "target_working_count")
        counts = "/".join(str(self._info_value(name, index)) for name in names)
        self._put_text(image, f"Working found: {counts}", (10, 150), 0.8)


class RenderTimedTransferInfoWrapper(OverlayWrapper):
    """Time until the cube has to be on the red disc."""

    def draw(self, image: np.ndarray, index: int) -> None:
        """See the class."""
        signal = self._attribute("signal_step", index)
        if signal is None:
            return
        base: Any = self.unwrapped
        begin, end = self._attribute("window_start", index), self._attribute("window_end", index)
        elapsed = self._info_value("elapsed_steps", index) or 0
        if elapsed < signal:
            phase, color = "WAIT", _WHITE
        elif elapsed < begin:
            phase, color = "COUNTING", _YELLOW
        elif elapsed <= end:
            phase, color = "WINDOW", _GREEN
        else:
            phase, color = "LATE", _RED
        x = image.shape[1] - 260
        delay = base.DELAY_STEPS
        on_red = bool(self._info_value("cube_on_red", index))
        self._put_text(image, f"T-{max(0, signal + delay - elapsed)}", (x, 30), 1.0, color)
        self._put_text(image, phase, (x, 60), 0.8, color)
        self._put_text(image, f"[{begin},{end}] d={delay}", (x, 90), 0.6)
        text, color = ("ON RED", _GREEN) if on_red else ("not on red", _WHITE)
        self._put_text(image, text, (x, 120), 0.6, color)


class RenderTraceShapeDebugWrapper(OverlayWrapper):
    """A map of the contour and what of it has been traced, with the phase below it.

    Args:
        env: The environment.
        minimap_size: Side of the map in pixels.
        minimap_top: Where it begins.
    """

    def __init__(
        self, env: gym.Env[Any, Any], minimap_size: int = 160, minimap_top: int = 130
    ) -> None:
        super().__init__(env)
        self.minimap_size = minimap_size
        self.minimap_top = minimap_top

    def draw(self, image: np.ndarray, index: int) -> None:
        """See the class."""
        left, top, size = 10, self.minimap_top, self.minimap_size
        drawing.fill(image, left, top, size, size, _BLACK, 0.7)
        active, number, length = self._active(index)
        visited = self._part("checkpoint_visited", index, active)
        waypoints = self._part("waypoints", index, active)
        if waypoints is not None:
            places = np.asarray(waypoints)
            middle = (places.max(0) + places.min(0)) / 2
            extent = max(float(np.ptp(places, axis=0).max()), 1e-6)

            def pixels(points: Any) -> np.ndarray:
                """World x is up, world y is left."""
                scaled = (np.asarray(points) - middle) * (0.8 * size / extent)
                return np.stack(
                    [left + size / 2 - scaled[:, 1], top + size / 2 - scaled[:, 0]], axis=1
                )

            drawing.line(image, pixels([*waypoints, waypoints[0]]), _WHITE)
            points = pixels(self._part("checkpoints", index, active))
            # Sequences have only the number of visited ones.
            colors = [_GREEN if seen else _YELLOW for seen in visited or ()]
            for (x, y), color in zip(points, colors or [_WHITE] * len(points)):
                drawing.dot(image, x, y, 3, color)
        name = _CONTOURS[number] if number is not None and 0 <= number < 3 else f"Shape {number}"
        below = top + size + 18
        if visited is not None:
            name = f"{name} [{sum(visited)}/{len(visited)}]"
        elif length is not None:
            checkpoints = self.unwrapped.NUM_CHECKPOINTS  # type: ignore[attr-defined]
            seen = round((self._info_value("active_visit_fraction", index) or 0) * checkpoints)
            name = f"{name} [{seen}/{checkpoints}]"
        self._put_text(image, name, (left, below), 0.5)
        masks = (("pre_demo_mask", "PRE-DEMO"), ("demo_mask", "DEMO"), ("action_mask", "ACTION"))
        phase = next((text for mask, text in masks if self._info_value(mask, index)), "")
        self._put_text(image, phase, (left, below + 18), 0.5)
        closed = self._info_value("is_contour_closed", index) or self._info_value(
            "is_active_contour_closed", index
        )
        self._put_text(image, f"Closed: {'YES' if closed else 'NO'}", (left, below + 36), 0.5)
        if length is not None:
            done = round((self._info_value("sequence_progress", index) or 0) * length)
            text = f"Seq {active + 1}/{length} Done {done}/{length}"
            self._put_text(image, text, (left, below + 54), 0.5)

    def _active(self, index: int) -> tuple[int, int | None, int | None]:
        """Index of the contour in the sequence, its shape, and the length of the sequence."""
        active = self._info_value("active_shape_idx", index)
        if active is None:
            return 0, self._info_value("oracle_info", index), None
        shapes = self._info_value("oracle_info", index) or []
        return (
            active,
            self._info_value("active_shape_id", index),
            sum(shape >= 0 for shape in shapes),
        )

    def _part(self, name: str, index: int, active: int) -> Any:
        """Points of one contour, (n, ...), as a list."""
        value = self._attribute(name, index)
        several = self.info.get("active_shape_idx") is not None
        return value[active] if value is not None and several else value


def named(mapping: Any, number: int | None) -> str:
    """A name by its number, of a dict or a list; "?" where there is none."""
    names = list(mapping.values()) if isinstance(mapping, dict) else list(mapping)
    return names[number] if number is not None and number < len(names) else "?"
