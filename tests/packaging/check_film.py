"""Fails unless the films, and the table of frames in them, are what was recorded."""

import sys

import av
import numpy as np

frames, *paths = sys.argv[1:]
for path in paths:
    with av.open(path) as film:
        pictures = [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]
    assert len(pictures) == int(frames), f"{path}: {len(pictures)} frames"
    moved = np.abs(pictures[0].astype(int) - pictures[-1]).max()
    assert moved > 50, f"{path}: nothing moves"
