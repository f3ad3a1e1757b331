"""Batches in the conventions of other libraries: Stable-Baselines3, LeRobot."""
