"""Libraries that parts of the package need and a plain installation lacks.

Messages name these, never a distribution of this project: the name ``engram`` belongs to another
project on the package index.
"""

from __future__ import annotations

# By extra of pyproject.toml.
LIBRARIES = {
    "mikasa": ("torch",),
    "video": ("av",),
    "play": ("aiohttp", "pillow"),
    "datasets": ("pyarrow", "av", "pandas", "pillow", "protobuf", "google-crc32c"),
}


def install_command(extra: str) -> str:
    """The command that installs the libraries of an extra."""
    return "pip install " + " ".join(LIBRARIES[extra])
