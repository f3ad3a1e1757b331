"""The distribution that installs this package: its name, and the libraries of its extras.

Messages name libraries, never a distribution of this project: the name ``engram`` belongs to
another project on the package index.
"""

from __future__ import annotations

import importlib.metadata
import warnings

from engram.errors import _one_line

NAME = "engram-sim"
LIBRARIES = {  # by extra of pyproject.toml
    "sb3": ("stable-baselines3",),
    "mikasa": ("torch",),
    "video": ("av",),
    "play": ("aiohttp", "pillow"),
    "servers": ("websockets", "msgpack", "aiohttp", "pillow"),
    "datasets": ("pyarrow", "av", "pandas", "pillow", "protobuf", "google-crc32c"),
    "hdf5": ("h5py",),
    "ray": ("ray",),
}
_OTHER = "engram"  # another project's; this one's before 0.5.0
_LONGEST = 200  # characters of its metadata, which anybody may have written


def install_command(extra: str) -> str:
    """The command that installs the libraries of an extra."""
    return "pip install " + " ".join(LIBRARIES[extra])


def warn_of_other_distribution(stacklevel: int) -> None:
    """Warns if a distribution `engram` is installed: both have files in the same folder."""
    found = next(iter(importlib.metadata.distributions(name=_OTHER)), None)
    if found is None:
        return
    warnings.warn(
        _one_line(
            f"the distribution {_OTHER} ({_describe(found)}) is installed in "
            f"{found.locate_file('')}. It is another project's, or this one's before 0.5.0; its "
            f"files may replace those of {NAME}, which installs this package. Remove it by "
            f"`pip uninstall {_OTHER}`, then install {NAME} again, from its wheel's file."
        ),
        stacklevel=stacklevel + 1,
    )


def _describe(found: importlib.metadata.Distribution) -> str:
    try:
        metadata = found.metadata
        known = [metadata[key] for key in ("Version", "Summary") if key in metadata]
    except Exception:  # damaged metadata
        known = []
    return ": ".join(known)[:_LONGEST] or "of an unknown version"
