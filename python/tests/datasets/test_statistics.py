"""Statistics and angles of states, as trainers normalise by them."""

from __future__ import annotations

import numpy as np
import pytest

from engram.datasets.frame_stats import FLOOR, Levels, Numbers, floored, of_values, raised
from engram.datasets.spaces import continuous

BOUNDS = (("min", "max"), ("q01", "q99"), ("q10", "q90"))


def columns(steps: int = 200) -> np.ndarray:
    """Numbers that never change, hardly, seldom and often."""
    rng = np.random.default_rng(1)
    seldom = np.ones(steps)
    seldom[0] = -1
    return np.stack(
        [
            np.full(steps, 0.04),
            0.04 + 1e-7 * rng.normal(size=steps),
            seldom,
            rng.uniform(-1, 1, steps),
        ],
        axis=1,
    ).astype(np.float32)


def normalized(values: np.ndarray, stats: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """As LeRobot's normaliser does: by mean and deviation, and by each pair of bounds."""
    result = {"std": (values - stats["mean"]) / (stats["std"] + 1e-8)}
    for low, high in BOUNDS:
        distance = stats[high] - stats[low]
        result[low] = 2 * (values - stats[low]) / np.where(distance == 0, 1e-8, distance) - 1
    return result


def test_a_little_noise_is_no_huge_input():
    values = columns()
    disturbed = values + 1e-4
    raw = normalized(disturbed, of_values(values))
    assert min(np.abs(raw[name]).max() for name in raw) > 500  # what the floor is for
    for name, inputs in normalized(disturbed, floored(of_values(values))).items():
        assert np.abs(inputs[:, :2]).max() < 0.1, name
        assert np.abs(inputs[:, 3]).max() < 2, name


def test_bounds_stay_in_order_and_wide_columns_as_they_are():
    raw, stats = of_values(columns()), floored(of_values(columns()))
    order = ["min", "q01", "q10", "q50", "q90", "q99", "max"]
    for low, high in zip(order, order[1:]):
        assert (stats[low] <= stats[high]).all(), (low, high)
    for low, high in BOUNDS:
        assert (stats[high] - stats[low] >= 2 * FLOOR * (1 - 1e-9)).all()
    assert (stats["std"] >= FLOOR).all()
    for name, values in raw.items():
        np.testing.assert_array_equal(stats[name][..., -1], values[..., -1])
    assert (stats["q01"][2], stats["q10"][2]) == (-1, -1)  # a gripper that closes once


def test_statistics_are_those_of_all_frames():
    rng = np.random.default_rng(3)
    episodes = [rng.normal(shift, 1, (steps, 2)) for shift, steps in ((0, 40), (5, 200), (-3, 7))]
    numbers = Numbers()
    for episode in episodes:
        stats = numbers.add(episode)
        assert (stats["std"] == episode.std(0)).all()
    frames = np.concatenate(episodes)
    total = numbers.total()
    for name, q in (("min", 0), ("q01", 0.01), ("q50", 0.5), ("q99", 0.99), ("max", 1)):
        np.testing.assert_array_equal(total[name], np.quantile(frames, q, axis=0))
    np.testing.assert_array_equal(total["std"], frames.std(0))
    assert total["count"] == [247]


@pytest.mark.parametrize(("kind", "most"), [(np.uint8, 250), (np.uint16, 60_000)])
def test_statistics_of_images_are_those_of_all_their_pixels(kind: type, most: int):
    """One camera of two, whose channels take turns."""
    rng = np.random.default_rng(4)
    episodes = [rng.integers(0, end, (5, 4, 6, 6), kind)[..., 3:] for end in (20, most)]
    levels = Levels(1 / 255)
    for episode in episodes:
        stats = levels.add(episode)
        np.testing.assert_allclose(stats["max"].ravel(), episode.max((0, 1, 2)) / 255)
    pixels = np.concatenate(episodes).reshape(-1, 3) / 255
    total = levels.total()
    assert total["mean"].shape == (3, 1, 1)
    np.testing.assert_allclose(total["mean"].ravel(), pixels.mean(0))
    np.testing.assert_allclose(total["std"].ravel(), pixels.std(0))
    for name, q in (("min", 0), ("q10", 0.1), ("q90", 0.9), ("max", 1)):
        expected = np.quantile(pixels, q, axis=0, method="inverted_cdf")
        np.testing.assert_allclose(total[name].ravel(), expected)


def test_readers_that_combine_episodes_find_the_floors():
    numbers = Numbers()
    parts = [numbers.add(columns(steps)) for steps in (3, 50, 200)]
    total = numbers.total()
    floor = floored(total)
    episodes = [raised(part, total, floor) for part in parts]
    weights = np.array([3, 50, 200])[:, None] / 253
    means = np.stack([episode["mean"] for episode in episodes])
    stds = np.stack([episode["std"] for episode in episodes])
    variance = (weights * (stds**2 + (means - total["mean"]) ** 2)).sum(0)
    np.testing.assert_allclose(np.sqrt(variance), floor["std"], rtol=1e-6)
    for low, high in BOUNDS[:1]:
        np.testing.assert_array_equal(np.min([one[low] for one in episodes], 0), floor[low])
        np.testing.assert_array_equal(np.max([one[high] for one in episodes], 0), floor[high])
    np.testing.assert_array_equal(episodes[1]["std"][3], parts[1]["std"][3])  # a wide column


def test_angles_do_not_jump():
    turn = np.linspace(-0.1, 0.1, 41)
    poses = np.zeros((41, 7), np.float32)
    poses[:, 3] = (np.pi + turn + np.pi) % (2 * np.pi) - np.pi  # of a hand that points down
    poses[:, 5] = (3.1 + turn + np.pi) % (2 * np.pi) - np.pi  # and is turned by half a turn
    assert np.abs(np.diff(poses, axis=0)).max() > 6
    assert np.abs(np.diff(continuous(poses), axis=0)).max() < 0.006
    others = [0, 1, 2, 4, 6]
    np.testing.assert_array_equal(continuous(poses)[:, others], poses[:, others])


@pytest.mark.parametrize("shape", [(7,), (5, 7), (2, 5, 7)])
def test_a_frame_alone_gives_the_same(shape):
    poses = np.random.default_rng(2).uniform(-np.pi, np.pi, shape).astype(np.float32)
    changed = continuous(poses)
    assert changed.dtype == np.float32
    alone = [continuous(pose) for pose in poses.reshape(-1, 7)]
    np.testing.assert_array_equal(changed.reshape(-1, 7), alone)
    np.testing.assert_allclose(np.exp(1j * changed), np.exp(1j * poses), atol=1e-6)
