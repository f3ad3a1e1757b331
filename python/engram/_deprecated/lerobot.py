"""Moved to engram.integrations.lerobot."""

from engram._deprecated import redirect

redirect("lerobot")
