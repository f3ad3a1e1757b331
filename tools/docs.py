#!/usr/bin/env python3
"""Writes what the docs take from the program: tools/docs.py PART [OPTION...].

    tables      facts of tasks in docs/, from `engram info`; --check: fails if one is stale
    modules     docs/pictures/modules.svg, from #include lines; --check likewise
    pictures    sheets of docs/pictures/tasks, by `engram record`
    props       docs/pictures/kit_props.png, of the props of engram.kit
    films       docs/pictures/films, of released policies
    notebooks   outputs of docs/notebooks

tools/docs.py PART --help prints the options. scripts/docs_site.sh builds the site.
"""

import argparse
import importlib

PARTS = ("tables", "modules", "pictures", "props", "films", "notebooks")


def main():
    parser = argparse.ArgumentParser(
        prog="tools/docs.py",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("part", metavar="PART", choices=PARTS)
    parser.add_argument("options", nargs=argparse.REMAINDER, metavar="OPTION")
    options = parser.parse_args()
    module = importlib.import_module(f"pages.{options.part}")
    module.main(options.options, f"tools/docs.py {options.part}")


if __name__ == "__main__":
    main()
