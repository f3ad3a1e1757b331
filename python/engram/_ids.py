"""Ids of tasks in Gymnasium's registry."""

from __future__ import annotations

NAMESPACE = "engram/"
