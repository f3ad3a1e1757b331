"""Checks of a policy server before a run: what answers mean and depend on."""
