#!/usr/bin/env python3
"""Runs the notebooks of docs/notebooks and stores in them what they print and draw.

notebooks.py [FILE...]; with an environment that has engram, torch, matplotlib, nbclient and
ipykernel: build/python-env/bin/python scripts/notebooks.py
"""

import sys
from pathlib import Path

import nbclient
import nbformat

FOLDER = Path(__file__).resolve().parent.parent / "docs" / "notebooks"


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


def main():
    for name in sys.argv[1:] or sorted(FOLDER.glob("*.ipynb")):
        notebook = executed(name, FOLDER)
        nbformat.write(notebook, name)
        print(name)


if __name__ == "__main__":
    main()
