"""Drawing of text, swatches and lines, for overlays."""

from __future__ import annotations

import functools
from importlib import resources
from typing import Any

import numpy as np

# font.npz: the letters from space to ~ of DejaVu Sans, as grey values, with the height at which the
# capitals of OpenCV's simplex font are at scale 1. "letters" (95, height, width), "widths" (95,),
# "ascent": rows above the baseline.
_FIRST = 32
_WHITE = (255, 255, 255)
_OUTLINE = (20, 20, 20)

Color = tuple[int, int, int]


@functools.cache
def _font() -> tuple[np.ndarray, np.ndarray, int]:
    with resources.files(__package__).joinpath("font.npz").open("rb") as file:
        font = np.load(file)
        return font["letters"], font["widths"], int(font["ascent"])


@functools.lru_cache(256)
def _letter(letter: str, scale: float) -> tuple[np.ndarray, float]:
    """Coverage of a letter, 0 to 1, and the distance of the next one."""
    letters, widths, _ = _font()
    number = ord(letter) - _FIRST
    number = number if 0 <= number < len(letters) else ord("?") - _FIRST
    coverage = letters[number].astype(np.float32) / 255
    if scale != 1:
        coverage = _resized(coverage, scale)
    return coverage, float(widths[number]) * scale


def _resized(image: np.ndarray, scale: float) -> np.ndarray:
    """Each axis by linear interpolation."""
    for axis in (0, 1):
        count = image.shape[axis]
        places = (np.arange(max(1, round(count * scale))) + 0.5) / scale - 0.5
        low = np.clip(np.floor(places).astype(int), 0, count - 1)
        high = np.minimum(low + 1, count - 1)
        share = np.clip(places - low, 0, 1).astype(np.float32)
        share = share[:, np.newaxis] if axis == 0 else share
        image = image.take(low, axis) * (1 - share) + image.take(high, axis) * share
    return image


def put_text(
    image: np.ndarray,
    text: str,
    place: tuple[int, int],
    scale: float = 1.0,
    color: Color = _WHITE,
    outlined: bool = True,
) -> None:
    """Writes a line, with a dark outline or without.

    Args:
        image: uint8 (height, width, 3), changed in place.
        text: The line.
        place: x and y of its baseline's beginning.
        scale: Size; at 1 capitals are 21 pixels high.
        color: Of the letters.
        outlined: Whether they have an outline.
    """
    *_, ascent = _font()
    letters = [_letter(letter, scale) for letter in text]
    width = int(sum(step for _, step in letters)) + 40
    height = max((coverage.shape[0] for coverage, _ in letters), default=0) + 4
    mask = np.zeros((height, width), np.float32)
    x = 2.0
    for coverage, step in letters:
        left = int(x)
        part = mask[2 : 2 + coverage.shape[0], left : left + coverage.shape[1]]
        np.maximum(part, coverage[:, : part.shape[1]], out=part)
        x += step
    top = place[1] - round(ascent * scale) - 2
    if outlined:
        shifted = [np.roll(np.roll(mask, dy, 0), dx, 1) for dy in (-1, 0, 1) for dx in (-1, 0, 1)]
        _blend(image, np.maximum.reduce(shifted), (place[0] - 2, top), _OUTLINE)
    _blend(image, mask, (place[0] - 2, top), color)


def text_width(text: str, scale: float = 1.0) -> int:
    """Pixels from the beginning of a line to where the next letter would be."""
    return round(sum(_letter(letter, scale)[1] for letter in text))


def _blend(image: np.ndarray, mask: np.ndarray, place: tuple[int, int], color: Color) -> None:
    x, y = place
    top, left = max(0, -y), max(0, -x)
    part = image[max(0, y) : y + mask.shape[0], max(0, x) : x + mask.shape[1]]
    share = mask[top : top + part.shape[0], left : left + part.shape[1], np.newaxis]
    part[:] = np.rint(part * (1 - share) + np.array(color, np.float32) * share)


def fill(
    image: np.ndarray, x: int, y: int, width: int, height: int, color: Any, share: float = 1.0
) -> None:
    """Fills a rectangle, or tints it."""
    part = image[max(0, y) : max(0, y + height), max(0, x) : max(0, x + width)]
    part[:] = np.rint(part * (1 - share) + np.array(color, np.float32)[:3] * share)


def swatch(image: np.ndarray, x: int, y: int, side: int, color: Any, border: Color) -> None:
    """A square of a colour with a border of two pixels around it."""
    fill(image, x - 2, y - 2, side + 4, side + 4, border)
    fill(image, x, y, side, side, color)


def dot(image: np.ndarray, x: float, y: float, radius: int, color: Color) -> None:
    """A disc."""
    column, row = round(x), round(y)
    rows, columns = np.ogrid[-radius : radius + 1, -radius : radius + 1]
    mask = (rows**2 + columns**2 <= radius**2).astype(np.float32)
    _blend(image, mask, (column - radius, row - radius), color)


def line(image: np.ndarray, points: np.ndarray, color: Color) -> None:
    """A line through points (n, 2) of x and y, one pixel wide."""
    for (x0, y0), (x1, y1) in zip(points[:-1], points[1:]):
        count = int(max(abs(x1 - x0), abs(y1 - y0))) + 1
        columns = np.rint(np.linspace(x0, x1, count)).astype(int)
        rows = np.rint(np.linspace(y0, y1, count)).astype(int)
        inside = (rows >= 0) & (rows < image.shape[0]) & (columns >= 0) & (columns < image.shape[1])
        image[rows[inside], columns[inside]] = color
