"""Frames of an episode: history, and images in the size that a server wants."""

from __future__ import annotations

import collections
import dataclasses
from typing import Any, Generic, TypeVar

import numpy as np
import numpy.typing as npt

from engram.servers.options import History

Array = npt.NDArray[Any]


@dataclasses.dataclass(frozen=True)
class Frame:
    """What a policy sees in one step."""

    rgb: Array | None  # (H, W, 6)
    state: Array | None  # in the layout of the keys; None: they name no part of it
    row: Array | None  # of obs="objects" or "state"


FrameT = TypeVar("FrameT")


class FrameHistory(Generic[FrameT]):
    """The frames of an episode that the next question may have."""

    def __init__(self, history: History) -> None:
        self._history = history
        longest = None if history.frames == 0 else (history.frames - 1) * history.stride + 1
        self._frames: collections.deque[FrameT] = collections.deque(maxlen=longest)
        self.last: FrameT | None = None

    def add(self, frame: FrameT) -> None:
        self._frames.append(frame)
        self.last = frame

    def take(self) -> list[FrameT]:
        """Frames of a question, the oldest first.

        Where an episode has too few, its first one is repeated.
        """
        frames = list(self._frames)
        if self._history.frames == 0:
            self._frames.clear()
            return frames
        last, stride = len(frames) - 1, self._history.stride
        steps = range(self._history.frames - 1, -1, -1)
        return [frames[max(0, last - i * stride)] for i in steps]


def resize(image: Array, size: tuple[int, int] | None) -> Array:
    """An image (..., H, W, 3) with its proportions in a size, black at two sides; bilinear."""
    if size is None or image.shape[-3:-1] == size:
        return np.ascontiguousarray(image)
    if image.ndim > 3:
        return np.stack([resize(one, size) for one in image])
    from PIL import Image

    given = Image.fromarray(np.ascontiguousarray(image))
    ratio = max(given.width / size[1], given.height / size[0])
    height, width = int(given.height / ratio), int(given.width / ratio)
    result = np.zeros((*size, 3), np.uint8)
    top, left = (size[0] - height) // 2, (size[1] - width) // 2
    result[top : top + height, left : left + width] = np.asarray(
        given.resize((width, height), Image.Resampling.BILINEAR)
    )
    return result
