"""Runs the notebooks of docs/notebooks and stores in them what they print and draw.

Needs engram, torch, matplotlib, nbclient and ipykernel: build/python-env/bin/python.
"""

import argparse
from pathlib import Path

import nbclient
import nbformat

FOLDER = Path(__file__).resolve().parent.parent.parent / "docs" / "notebooks"


def executed(file, folder):
    """The notebook with fresh outputs; it runs in that folder."""
    notebook = nbformat.read(file, as_version=4)
    client = nbclient.NotebookClient(
        notebook,
        timeout=300,
        record_timing=False,
        coalesce_streams=True,
        resources={"metadata": {"path": str(folder)}},
    )
    client.execute()
    # Which Python it was that ran them is not the reader's business.
    notebook.metadata["language_info"] = {"name": "python"}
    return notebook


def main(given, prog):
    parser = argparse.ArgumentParser(prog=prog, description=__doc__)
    parser.add_argument("files", nargs="*", metavar="FILE", help="default: all of docs/notebooks")
    for name in parser.parse_args(given).files or sorted(FOLDER.glob("*.ipynb")):
        notebook = executed(name, FOLDER)
        nbformat.write(notebook, name)
        print(name)
