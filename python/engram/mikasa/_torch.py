"""Import of torch, with an error that explains its installation."""

from __future__ import annotations

from engram._distribution import install_command
from engram.errors import UnavailableError

try:
    import torch
except ImportError:
    raise UnavailableError(f"engram.mikasa needs torch: {install_command('mikasa')}") from None

CPU = torch.device("cpu")

__all__ = ["CPU", "torch"]
