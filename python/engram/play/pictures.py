"""Encoding of pictures for the page."""

from __future__ import annotations

import io
import json
import struct
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image

Picture = npt.NDArray[np.uint8]


def jpeg(picture: Picture, quality: int = 88) -> bytes:
    """A picture (height, width, 3) as a JPEG file without chroma subsampling."""
    out = io.BytesIO()
    Image.fromarray(picture).save(out, "JPEG", quality=quality, subsampling=0)
    return out.getvalue()


def sensors(rgb: Picture) -> bytes:
    """Base and wrist camera (height, width, 6) side by side."""
    return jpeg(np.concatenate([rgb[..., :3], rgb[..., 3:]], axis=1), 92)


def mosaic(pictures: list[Picture], columns: int) -> Picture:
    """Pictures of one size in rows."""
    rows = [
        np.concatenate(pictures[start : start + columns], axis=1)
        for start in range(0, len(pictures), columns)
    ]
    return np.concatenate(rows, axis=0)


def packed(header: dict[str, Any], *files: bytes) -> bytes:
    """A message: the header's length, the header with the sizes of the files, the files."""
    text = json.dumps({**header, "sizes": [len(file) for file in files]}).encode()
    return b"".join([struct.pack("<I", len(text)), text, *files])
