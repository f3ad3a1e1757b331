"""Moved to engram.integrations.sb3."""

from engram._deprecated import redirect

redirect("sb3")
