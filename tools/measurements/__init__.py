"""Suites of tools/measure.py, a module each: `add_options(parser)` and `run(options)`."""
