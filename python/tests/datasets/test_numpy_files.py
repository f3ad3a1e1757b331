"""Demonstrations as engram collects them, read by NumPy alone."""

from __future__ import annotations

import numpy as np
import pytest
from demonstrations import EPISODES, SEED


def test_numpy_reads_the_fields_of_the_table(folder):
    assert len(folder) == EPISODES
    for number, file in enumerate(folder.files):
        with np.load(file, allow_pickle=False) as arrays:
            steps = int(arrays["episode_length"])
            assert steps == folder.metadata["episode_lengths"][number]
            expected = {
                "rgb": ("uint8", (steps, 128, 128, 6)),
                "proprio": ("float32", (steps, 7)),
                "action": ("float32", (steps, 7)),
                "reward": ("float32", (steps,)),
                "success": ("int32", (steps,)),
                "done": ("int32", (steps,)),
                "success_once": ("bool", ()),
                "episode_length": ("int32", ()),
                "episode_seed": ("int64", ()),
            }
            assert set(arrays.files) == {*expected, "language_instruction"}
            for name, (dtype, shape) in expected.items():
                assert (str(arrays[name].dtype), arrays[name].shape) == (dtype, shape), name
            text = arrays["language_instruction"]
            assert text.dtype.kind == "U"
            assert text.shape == ()
            assert text.item().endswith(".")
            assert arrays["success_once"].item() is True
            assert arrays["episode_seed"] == folder.metadata["episode_seeds"][number] >= SEED
            assert np.abs(arrays["action"]).max() <= 1
            assert arrays["rgb"].std() > 5
            success = arrays["success"]
            assert success[-1] == 1
            assert success[:-1].sum() == 0
            np.testing.assert_array_equal(success, arrays["done"])
            total = arrays["reward"].astype(np.float64).sum()
            assert total == pytest.approx(folder.metadata["reward_sums"][number], rel=1e-12)


def test_the_writer_makes_headers_as_numpy_does(folder, tmp_path):
    import io
    import zipfile

    with zipfile.ZipFile(folder.files[0]) as archive, np.load(folder.files[0]) as arrays:
        assert archive.testzip() is None
        for member in archive.infolist():
            assert member.date_time == (1980, 1, 1, 0, 0, 0)
            written = io.BytesIO()
            np.save(written, arrays[member.filename.removesuffix(".npy")])
            assert archive.read(member)[:128] == written.getvalue()[:128], member.filename
