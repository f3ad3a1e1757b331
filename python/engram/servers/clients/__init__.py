"""Clients: one connection for each episode in progress."""
