"""Import of torch, with an error that explains its installation."""

from __future__ import annotations

from engram.errors import UnavailableError

try:
    import torch
except ImportError:
    raise UnavailableError("engram.mikasa needs torch: pip install 'engram[mikasa]'") from None

CPU = torch.device("cpu")

__all__ = ["CPU", "torch"]
