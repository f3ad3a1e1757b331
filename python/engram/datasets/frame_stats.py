"""Statistics by which LeRobot's policies normalise: per episode, and of a whole data set.

Policies divide by a standard deviation or by the distance of two bounds. Of numbers that hardly
change these are tiny, and a little noise would be a huge input; so data sets have a floor.
"""

from __future__ import annotations

import numpy as np

from engram import _core

Stats = dict[str, np.ndarray]

_QUANTILES = {"q01": 0.01, "q10": 0.10, "q50": 0.50, "q90": 0.90, "q99": 0.99}
_PAIRS = (("min", "max"), ("q01", "q99"), ("q10", "q90"))  # each within the one before it
_MAX_IMAGES = 100  # of an episode, evenly spread
FLOOR = 0.01  # of standard deviations, in m, rad, or shares of an action's range


class Numbers:
    """Statistics of numbers, (T,) or (T, n): one value per component."""

    def __init__(self) -> None:
        self._episodes: list[np.ndarray] = []

    def add(self, values: np.ndarray) -> Stats:
        """Statistics of an episode."""
        self._episodes.append(values)
        return of_values(values)

    def total(self) -> Stats:
        """Statistics of all frames; quantiles of episodes cannot be combined."""
        return of_values(np.concatenate(self._episodes))


class Levels:
    """Statistics of images: one value per channel, shaped (C, 1, 1), of up to 100 an episode.

    unit: what a step of the pixels' numbers stands for.
    """

    def __init__(self, unit: float = 1.0) -> None:
        self._unit = unit
        self._counts: np.ndarray = np.zeros((1, 1), np.int64)
        self._images = 0

    def add(self, images: np.ndarray) -> Stats:
        """Statistics of an episode, (T, H, W, C) or (T, H, W)."""
        chosen = np.unique(np.linspace(0, len(images) - 1, _MAX_IMAGES).round().astype(int))
        images = images.reshape(*images.shape[:3], -1)
        counts = np.zeros((images.shape[-1], np.iinfo(images.dtype).max + 1), np.int64)
        _core.count_levels(images, chosen, counts)
        self._counts = self._counts + counts
        self._images += len(chosen)
        return self._of(counts, len(chosen))

    def total(self) -> Stats:
        """Statistics of all episodes."""
        return self._of(self._counts, self._images)

    def _of(self, counts: np.ndarray, images: int) -> Stats:
        counts = counts[:, : 1 + np.flatnonzero(counts.any(0))[-1]]
        levels = self._unit * np.arange(counts.shape[-1])
        below = np.cumsum(counts, -1)
        pixels = below[0, -1]
        mean = counts @ levels / pixels
        squares = (counts * (levels - mean[:, None]) ** 2).sum(-1) / pixels
        ranks = {"min": 1 / pixels, "max": 1.0, **_QUANTILES}
        stats = {
            name: levels[[np.searchsorted(row, rank * pixels) for row in below]]
            for name, rank in ranks.items()
        }
        stats |= {"mean": mean, "std": np.sqrt(squares)}
        shaped = {name: values.reshape(-1, 1, 1) for name, values in stats.items()}
        return shaped | {"count": np.array([images])}


def of_values(values: np.ndarray) -> Stats:
    """Statistics of numbers, (T,) or (T, n): one value per component."""
    table = values.reshape(len(values), -1).astype(np.float64)
    stats = {
        "min": table.min(0),
        "max": table.max(0),
        "mean": table.mean(0),
        "std": table.std(0),
        "count": np.array([len(values)]),
    }
    return stats | dict(zip(_QUANTILES, np.quantile(table, list(_QUANTILES.values()), axis=0)))


def floored(stats: Stats) -> Stats:
    """The statistics with a standard deviation of FLOOR and bounds 2 FLOOR apart, or more.

    Of two bounds that are closer, the next wider ones take the place; the widest move apart.
    """
    result = stats | {"std": np.maximum(stats["std"], FLOOR)}
    middle = (stats["min"] + stats["max"]) / 2
    wider = middle - FLOOR, middle + FLOOR
    for names in _PAIRS:
        low, high = (stats[name] for name in names)
        near = high - low < 2 * FLOOR
        wider = np.where(near, wider[0], low), np.where(near, wider[1], high)
        result |= dict(zip(names, wider))
    return result


def raised(episode: Stats, total: Stats, floor: Stats) -> Stats:
    """Statistics of an episode from which readers combine `floor`, where it differs from `total`.

    Readers of version 2.1 combine episodes: variances about the common mean, outermost bounds.
    """
    result = dict(episode)
    for name in floor:
        if name != "count":
            result[name] = np.where(floor[name] == total[name], episode[name], floor[name])
    missing = floor["std"] ** 2 - total["std"] ** 2
    result["std"] = np.sqrt(episode["std"] ** 2 + missing)
    return result


def as_lists(stats: dict[str, Stats]) -> dict[str, dict[str, list]]:
    """The statistics of features as JSON has them."""
    return {
        key: {name: value.tolist() for name, value in values.items()}
        for key, values in stats.items()
    }


def flat(prefix: str, stats: dict[str, Stats]) -> dict[str, list]:
    """Columns of a table, named prefix/feature/statistic."""
    return {
        f"{prefix}/{key}/{name}": values
        for key, lists in as_lists(stats).items()
        for name, values in lists.items()
    }
