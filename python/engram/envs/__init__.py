"""Environments: a batch (``VectorEnv``), a single one (``Env``), one of a batch (``SubEnv``).

``engram.VectorEnv`` and ``engram.Env`` are their public names.
"""
