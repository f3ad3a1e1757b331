#!/usr/bin/env python3
"""Measures engram and writes the results: tools/measure.py SUITE [OPTION...].

Results are CSV files in docs/data, whose README.md explains them.
"""

import argparse
import importlib

from measurements import summary
from measurements.common import ROOT

SUITES = {
    "memory": "what policies without memory achieve: memory.csv, random_draws.csv (45 minutes)",
    "perturbations": "policies under perturbations: perturbations_*.csv (an hour)",
    "variants": "constants and values that were tried: constants.csv, tried_values.csv",
    "determinism": "equal bits in 19 configurations: determinism.csv (25 minutes)",
    "evaluation": "equal results of `engram eval` for threads, ranks and shards; writes nothing",
    "standing_still": "returns of success and of waiting before it: standing_still.csv",
    "pictures": "pictures beside the original's; writes nothing",
    "build": "what a build costs, cold and warm; writes nothing",
    "bench": "speed: speed.csv, speed_budget.csv",
    "summary": "the figures in docs/data/README.md, from the CSV files",
    "check": "agreement of docs/data with the program; writes nothing",
}
WRITERS = ("memory", "perturbations", "variants", "determinism", "bench")  # of CSV files


def main(given=None):
    parser = argparse.ArgumentParser(prog="tools/measure.py", description=__doc__.split(":")[0])
    suites = parser.add_subparsers(dest="suite", metavar="SUITE", required=True)
    for name, text in SUITES.items():
        module = importlib.import_module(f"measurements.{name}")
        own = suites.add_parser(name, help=text, description=module.__doc__)
        own.add_argument(
            "--engram",
            default=str(ROOT / "build" / "release" / "engram"),
            metavar="COMMAND",
            help="default: build/release/engram, which `scripts/build.sh release engram_cli` makes",
        )
        module.add_options(own)
        own.set_defaults(run=module.run)
    options = parser.parse_args(given)
    options.run(options)
    if options.suite in WRITERS:
        summary.run(options)


if __name__ == "__main__":
    main()
