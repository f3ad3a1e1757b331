"""Moved to engram.factory."""

from engram._deprecated import redirect

redirect("making")
