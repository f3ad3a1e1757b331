"""Moved to engram.tasks."""

from engram._deprecated import redirect

redirect("registry")
