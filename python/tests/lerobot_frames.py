"""Comparison of a LeRobotDataset, whatever its version, with the demonstrations it was made of."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from engram.datasets.frame_stats import FLOOR
from engram.datasets.spaces import continuous


def check_frames(dataset: Any, folder: Any, fps: int, exact: bool) -> None:
    """Every frame's numbers, text and pictures, which are exact unless they are of videos."""
    assert len(dataset) == sum(folder.metadata["episode_lengths"])
    stats = dataset.meta.stats["observation.state"]
    assert (np.array(stats["std"]) >= FLOOR * (1 - 1e-6)).all()
    assert stats["std"][3] < 0.1  # roll, which does not jump
    number = 0
    for index, episode in enumerate(folder):
        state = continuous(episode.proprio)
        assert (state >= stats["min"]).all()
        assert (state <= stats["max"]).all()
        for step in range(len(episode)):
            item = dataset[number]
            number += 1
            np.testing.assert_array_equal(item["observation.state"].numpy(), state[step])
            np.testing.assert_array_equal(item["action"].numpy(), episode.action[step])
            assert item["task"] == episode.language_instruction
            assert (item["episode_index"], item["frame_index"]) == (index, step)
            assert item["timestamp"].item() == pytest.approx(step / fps)
            for key, image in (("top", episode.image[step]), ("wrist", episode.wrist_image[step])):
                seen = item[f"observation.images.{key}"].permute(1, 2, 0).numpy() * 255
                assert seen.shape == (128, 128, 3)
                error = np.abs(seen - image)
                # Videos are lossy, but show the right frame: neighbours in the wrist camera, which
                # moves, differ by more.
                assert error.max() < 0.01 if exact else error.mean() < 9, (key, index, step)
