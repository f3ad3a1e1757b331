"""Moved to engram.envs.vector_env."""

from engram._deprecated import redirect

redirect("vector_env")
