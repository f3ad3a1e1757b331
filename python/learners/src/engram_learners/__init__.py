"""Learners with memory for engram's tasks: research, in modules that share their parts.

Each learner is a program: `python -m engram_learners.distil --help`. The README lists them.
"""
