"""Moved to engram.envs.sub_env."""

from engram._deprecated import redirect

redirect("sub_env")
