"""Another distribution `engram` beside this one is reported when the package is imported."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

IMPORT = "import engram, engram.envs.env; import engram; print(engram.__version__)"


def plant(folder: Path, name: str, metadata: str | bytes | None) -> None:
    """What an installer leaves of a distribution."""
    place = folder / f"{name}.dist-info"
    place.mkdir(parents=True)
    if metadata is not None:
        content = metadata.encode() if isinstance(metadata, str) else metadata
        (place / "METADATA").write_bytes(content)


def import_beside(folder: Path, *options: str, code: str = IMPORT) -> str:
    """Standard error of an import."""
    done = subprocess.run(
        [sys.executable, *options, "-c", code],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(folder)},
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stderr


def test_alone_it_says_nothing(tmp_path):
    plant(tmp_path, "engram_tools-1.0", "Metadata-Version: 2.1\nName: engram-tools\nVersion: 1.0\n")
    plant(tmp_path, "engram_sim-0.5.0", "Metadata-Version: 2.1\nName: engram-sim\nVersion: 0.5.0\n")
    assert import_beside(tmp_path, "-W", "error") == ""


@pytest.mark.parametrize("folder", ["engram-0.1.0a1", "Engram-0.1.0a1"])
def test_another_distribution_is_named_once(tmp_path, folder):
    plant(
        tmp_path,
        folder,
        "Metadata-Version: 2.1\nName: engram\nVersion: 0.1.0a1\nSummary: Notes of others\n",
    )
    error = import_beside(tmp_path)
    assert error.count("UserWarning") == 1
    assert "the distribution engram (0.1.0a1: Notes of others) is installed in " in error
    assert str(tmp_path) in error
    assert "`pip uninstall engram`" in error
    assert "engram-sim" in error
    assert "<string>:1" in error  # where it is imported


def test_the_command_reports_it_too(tmp_path):
    plant(tmp_path, "engram-0.1.0", "Metadata-Version: 2.1\nName: engram\nVersion: 0.1.0\n")
    done = subprocess.run(
        [Path(sys.executable).with_name("engram"), "--version"],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        check=False,
    )
    assert done.returncode == 0
    assert done.stderr.count("the distribution engram (0.1.0)") == 1


@pytest.mark.parametrize(
    "metadata",
    [
        None,
        b"",
        b"\xff\xfe\x00nonsense",
        b"Name: engram\nVersion: \x1b[31m1\x9b2J\nSummary: " + b"long " * 100_000,
        "Name: engram\nVersion: 1\nSummary: \u202eturned\n",
        b"Name: engram\nSummary: two\n lines\n",
    ],
    ids=["none", "empty", "binary", "escapes", "direction", "lines"],
)
def test_any_metadata_are_shown_on_one_printable_line(tmp_path, metadata):
    plant(tmp_path, "engram-1", metadata)
    code = (
        "import warnings\n"
        "with warnings.catch_warnings(record=True) as caught:\n"
        "    warnings.simplefilter('always')\n"
        "    import engram\n"
        "[one] = [str(w.message) for w in caught if 'pip uninstall' in str(w.message)]\n"
        "assert one.isprintable() and len(one) < 2000, one\n"
    )
    assert import_beside(tmp_path, code=code) == ""
