"""Moved to engram.gym_registration."""

from engram._deprecated import redirect

redirect("registration")
