"""Nested observations as one tensor."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from engram.mikasa._torch import torch

__all__ = ["flatten_state_dict"]


def flatten_state_dict(
    state_dict: Mapping[str, Any], use_torch: bool = False, device: Any = None
) -> Any:
    """All values of nested dicts beside each other, in their order: float32 (B, n).

    Args:
        state_dict: Tensors, arrays or lists of B rows, in dicts of any depth.
        use_torch: A tensor comes back, not an array.
        device: Of the result.
    """
    parts = [part for part in _rows(state_dict) if part.shape[-1] > 0]
    flat = torch.cat(parts, dim=-1) if parts else torch.zeros(0)
    return flat.to(device) if use_torch else flat.numpy()


def _rows(value: Any) -> list[torch.Tensor]:
    if isinstance(value, Mapping):
        return [part for one in value.values() for part in _rows(one)]
    given = value if isinstance(value, torch.Tensor) else torch.as_tensor(np.asarray(value))
    given = given.to(torch.float32)
    return [given[:, None] if given.ndim == 1 else given.reshape(len(given), -1)]
