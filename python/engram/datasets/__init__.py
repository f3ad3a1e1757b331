"""Demonstrations of `engram collect`, and their conversion to RLDS, LeRobotDataset and HDF5.

    python -m engram.datasets rlds FOLDER       # data_npz/<id> -> data_rlds/<id>/1.0.0
    python -m engram.datasets lerobot FOLDER    # data_npz/<id> -> data_lerobot/<id>
    python -m engram.datasets hdf5 FOLDER       # data_npz/<id> -> data_hdf5/<id>
    python -m engram.datasets replay FOLDER     # plays the stored actions again and compares

Nothing here but `replay` needs the compiled part of engram. The formats are described in
docs/datasets.md.
"""

from engram.datasets.checks import DatasetError
from engram.datasets.episodes import DemonstrationFolder, Episode, find_folders

__all__ = ["DatasetError", "DemonstrationFolder", "Episode", "find_folders"]
