"""Statistics by which LeRobot's policies normalise: per episode, and of a whole data set.

Policies divide by a standard deviation or by the distance of two bounds. Of numbers that hardly
change these are tiny, and a little noise would be a huge input; so they have a floor.
"""

from __future__ import annotations

import numpy as np

_QUANTILES = {"q01": 0.01, "q10": 0.10, "q50": 0.50, "q90": 0.90, "q99": 0.99}
_PAIRS = (("min", "max"), ("q01", "q99"), ("q10", "q90"))  # each within the one before it
_MAX_IMAGES = 100  # of an episode, evenly spread
FLOOR = 0.01  # of standard deviations, in m, rad, or shares of an action's range


def of_values(values: np.ndarray) -> dict[str, np.ndarray]:
    """Statistics of numbers, (T,) or (T, n): one value per component."""
    table = values.reshape(len(values), -1).astype(np.float64)
    stats = {
        "min": table.min(0),
        "max": table.max(0),
        "mean": table.mean(0),
        "std": table.std(0),
        "count": np.array([len(values)]),
    }
    return stats | {name: np.quantile(table, q, axis=0) for name, q in _QUANTILES.items()}


def floored(stats: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
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


def of_images(images: np.ndarray) -> dict[str, np.ndarray]:
    """Statistics of images, (T, H, W, 3) bytes: values of 0 to 1 per channel, shaped (3, 1, 1)."""
    return _of_channels(images, np.arange(256) / 255)


def of_maps(maps: np.ndarray) -> dict[str, np.ndarray]:
    """Statistics of depth or segmentation, (T, H, W): the numbers as they are, shaped (1, 1, 1)."""
    return _of_channels(maps[..., None], np.arange(int(maps.max()) + 1, dtype=np.float64))


def _of_channels(images: np.ndarray, levels: np.ndarray) -> dict[str, np.ndarray]:
    """levels: what the pixels' numbers, from 0 on, stand for."""
    chosen = np.unique(np.linspace(0, len(images) - 1, _MAX_IMAGES).round().astype(int))
    channels = []
    for channel in range(images.shape[-1]):
        counts = np.bincount(images[chosen, ..., channel].ravel(), minlength=len(levels))
        share = counts / counts.sum()
        present = np.flatnonzero(counts)
        mean = share @ levels
        cumulated = np.cumsum(share)
        stats = {
            "min": levels[present[0]],
            "max": levels[present[-1]],
            "mean": mean,
            "std": np.sqrt(share @ (levels - mean) ** 2),
        }
        stats |= {
            name: levels[min(len(levels) - 1, int(np.searchsorted(cumulated, q)))]
            for name, q in _QUANTILES.items()
        }
        channels.append(stats)
    stats = {name: np.array([s[name] for s in channels]).reshape(-1, 1, 1) for name in channels[0]}
    return stats | {"count": np.array([len(chosen)])}


def combined(episodes: list[dict[str, dict[str, np.ndarray]]]) -> dict[str, dict[str, list]]:
    """Statistics over all episodes, as LeRobot combines them: quantiles are weighted means."""
    result = {}
    for key in episodes[0]:
        parts = {
            name: np.stack([episode[key][name] for episode in episodes])
            for name in episodes[0][key]
        }
        counts = parts["count"]
        weights = counts.reshape(-1, *[1] * (parts["mean"].ndim - 1)) / counts.sum()
        mean = (parts["mean"] * weights).sum(0)
        total = {
            "min": parts["min"].min(0),
            "max": parts["max"].max(0),
            "mean": mean,
            "std": np.sqrt(((parts["std"] ** 2 + (parts["mean"] - mean) ** 2) * weights).sum(0)),
            "count": counts.sum(0),
        }
        total |= {name: (parts[name] * weights).sum(0) for name in _QUANTILES}
        result[key] = {name: value.tolist() for name, value in total.items()}
    return result


def flat(prefix: str, stats: dict[str, dict[str, np.ndarray]]) -> dict[str, list]:
    """Columns of a table, named prefix/feature/statistic."""
    return {
        f"{prefix}/{key}/{name}": value.tolist()
        for key, values in stats.items()
        for name, value in values.items()
    }
