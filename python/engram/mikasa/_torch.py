"""torch, or an error that says how to get it."""

from __future__ import annotations

from engram.errors import UnavailableError

try:
    import torch
except ImportError:
    raise UnavailableError("engram.mikasa needs torch: pip install 'engram[mikasa]'") from None

CPU = torch.device("cpu")

__all__ = ["CPU", "torch"]
