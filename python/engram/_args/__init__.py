"""Checks and conversions of what users pass in; every error names the argument."""
