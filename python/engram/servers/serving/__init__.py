"""A policy server of engram's own, for tests of clients and for learnt policies."""
