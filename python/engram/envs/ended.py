"""Errors about steps of environments whose episodes have ended."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from engram.errors import BadStateError

# In the library's message about such a step.
ENDED = re.compile(r"the episode of environment \d+ has ended")


def raise_if_ended(error: BadStateError, views: Mapping[str, Any]) -> None:
    """Raises the error of episodes that have ended, if it is one, with all their indices."""
    if not ENDED.search(str(error)):
        return
    ended = np.flatnonzero(views["terminated"] | views["truncated"])
    indices = ", ".join(map(str, ended[:10])) + (", ..." if len(ended) > 10 else "")
    raise BadStateError(
        f"episodes of environments {indices} have ended: reset them, with "
        'options={"reset_mask": terminated | truncated}, or make the batch with '
        'after_end="hold" or "continue"'
    ) from None
