"""Moved to engram.envs.env."""

from engram._deprecated import redirect

redirect("env")
