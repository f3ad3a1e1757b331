"""What a check has found."""

from __future__ import annotations

import dataclasses


@dataclasses.dataclass(frozen=True)
class Finding:
    """A likely mistake, or what should be known before a run.

    Attributes:
        mistake: False for what may be right.
        what: What was measured.
        likely: The likely reason.
        remedy: Options, or what to change.
    """

    mistake: bool
    what: str
    likely: str
    remedy: str = ""
