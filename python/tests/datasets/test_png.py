"""PNG files of pictures in data sets, opened by Pillow."""

from __future__ import annotations

import io

import numpy as np
import pytest

pytest.importorskip("PIL")

from PIL import Image

from engram.datasets import work


@pytest.mark.parametrize("shape", [(128, 128, 3), (1, 1, 3), (5, 7, 3), (128, 128), (1, 1), (3, 8)])
@pytest.mark.parametrize("kind", ["noise", "flat", "view"])
def test_pillow_reads_the_same_pixels(shape, kind):
    bits = np.uint8 if len(shape) == 3 else np.uint16
    high = np.iinfo(bits).max
    rng = np.random.default_rng(1)
    image = rng.integers(0, high, shape, bits, endpoint=True)
    if kind == "flat":
        image[:] = high - 1
    if kind == "view":  # one camera of several
        image = np.stack([image, image], axis=-1)[..., 1]
    with Image.open(io.BytesIO(work.png(image))) as opened:
        opened.load()
        assert opened.format == "PNG"
        np.testing.assert_array_equal(np.asarray(opened), image)


def test_equal_pictures_are_the_same_file():
    images = np.zeros((3, 16, 16, 3), np.uint8)
    images[1] = 7
    first, other, last = work.pngs(images)
    assert first is last
    assert first != other
