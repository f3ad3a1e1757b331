"""The space of images, whose bounds take up no memory."""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys

import numpy as np
import pytest
from gymnasium import spaces
from gymnasium.vector.utils import batch_space, concatenate, create_empty_array, iterate

from engram.envs.spaces import ImageBox

SHAPE = (6, 5, 3)


def plain(shape: tuple[int, ...] = SHAPE, seed: int | None = None) -> spaces.Box:
    return spaces.Box(0, 255, shape, np.uint8, seed)


def test_an_image_box_equals_gymnasiums():
    box = ImageBox(SHAPE)
    assert box == plain()
    assert plain() == box
    assert box == ImageBox(SHAPE)
    assert box != ImageBox((6, 5, 4))
    assert box != plain((6, 5, 4))
    assert box != spaces.Box(0, 254, SHAPE, np.uint8)
    assert spaces.Box(-1, 255, SHAPE, np.int16) != box
    assert repr(box) == repr(plain())
    assert box.is_bounded("both")
    for name in ("low", "high", "bounded_below", "bounded_above"):
        ours, theirs = getattr(box, name), getattr(plain(), name)
        np.testing.assert_array_equal(ours, theirs)
        assert ours.dtype == theirs.dtype
        assert ours.strides == (0, 0, 0)


def test_its_samples_are_gymnasiums():
    np.testing.assert_array_equal(ImageBox(SHAPE, 7).sample(), plain(seed=7).sample())
    ours, theirs = ImageBox(SHAPE), plain()
    ours.seed(3)
    theirs.seed(3)
    for _ in range(2):
        np.testing.assert_array_equal(ours.sample(), theirs.sample())


def test_image_boxes_contain_the_same_as_gymnasiums():
    box = ImageBox(SHAPE)
    image = box.sample()
    assert box.contains(image)
    assert not box.contains(image[1:])
    assert not box.contains(image.astype(np.int16))
    assert not box.contains(image.astype(np.float32))
    for other in (image.astype(np.bool_), image.tolist(), "image"):
        assert box.contains(other) == plain().contains(other)


@pytest.mark.parametrize("of", [copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))])
def test_copies_and_pickles_are_small_and_the_same(of):
    box = ImageBox((1000, 1000, 1000), 5)
    copied = of(box)
    assert copied == box
    assert copied.low.strides == (0, 0, 0)
    assert len(pickle.dumps(copied)) < 2000
    small = ImageBox(SHAPE, 5)
    np.testing.assert_array_equal(of(small).sample(), plain(seed=5).sample())


def test_batches_of_it_are_gymnasiums():
    batched = batch_space(ImageBox(SHAPE, 2), 4)
    theirs = batch_space(plain(seed=2), 4)
    assert isinstance(batched, ImageBox)
    assert batched == theirs
    np.testing.assert_array_equal(batched.sample(), theirs.sample())
    both = batch_space(spaces.Dict(rgb=ImageBox(SHAPE), proprio=spaces.Box(-1, 1, (7,))), 4)
    assert both == batch_space(spaces.Dict(rgb=plain(), proprio=spaces.Box(-1, 1, (7,))), 4)
    assert both["rgb"].low.strides == (0, 0, 0, 0)
    rows = list(iterate(batched, batched.sample()))
    empty = create_empty_array(ImageBox(SHAPE), n=4)
    np.testing.assert_array_equal(concatenate(ImageBox(SHAPE), rows, empty), np.stack(rows))
    assert spaces.flatdim(batched) == spaces.flatdim(theirs)


# In a process of its own: what others have left free would be used first.
MEMORY_OF_A_BATCH = """
import resource, engram

def most():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024

options = dict(obs_mode="rgb", threads=1, copy=False, autoreset_mode="next_step")
engram.make_vec("RememberColor3-VLA-v0", 1, **options).reset()
before = most()
env = engram.make_vec("RememberColor3-VLA-v0", 1000, **options)
images = env.reset()[0]["rgb"]
assert env.observation_space["rgb"].shape == images.shape
print(most() - before - images.nbytes / 2**20)
"""


def test_a_thousand_environments_take_little_more_than_their_images():
    command = [sys.executable, "-c", MEMORY_OF_A_BATCH]
    result = subprocess.run(command, check=True, capture_output=True, text=True)
    assert float(result.stdout) < 40  # MB
