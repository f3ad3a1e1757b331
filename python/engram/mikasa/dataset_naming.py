"""Names of folders that hold data sets."""

from __future__ import annotations

import re

__all__ = ["env_id_to_dataset_name", "is_dataset_name"]

# Ends of words in an id: before capitals, and before numbers after words. Single letters keep their
# number: v0, 3x2.
_WORD_ENDS = re.compile(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])|(?<=[A-Za-z]{2})(?=[0-9])")


def is_dataset_name(value: str) -> bool:
    """True if it has only lower-case letters, digits and underscores."""
    return bool(value) and all(one.islower() or one.isdigit() or one == "_" for one in value)


def env_id_to_dataset_name(env_id: str) -> str:
    """The folder of an id: RememberColor3-VLA-v0 is in remember_color_3_vla_v0."""
    if is_dataset_name(env_id):
        return env_id
    words = [_WORD_ENDS.sub("_", part) for part in env_id.split("-") if part]
    return "_".join(words).lower()
