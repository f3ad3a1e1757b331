"""Conversion in a C locale, without Python's UTF-8 mode."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest
from sound_dataset import EPISODES, ID, arrays_of, write_sound

pytest.importorskip("pyarrow")
pytest.importorskip("av")

C_LOCALE = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}


def convert(folder, out: bytes) -> subprocess.CompletedProcess:
    command = [sys.executable, "-m", "engram.datasets", "lerobot", folder, "--images", "--out", out]
    return subprocess.run(command, env={**os.environ, **C_LOCALE}, capture_output=True, text=True)


def test_a_name_that_the_locale_cannot_hold_is_one_sentence(tmp_path) -> None:
    write_sound(tmp_path)
    done = convert(tmp_path, os.fsencode(tmp_path) + b"/\xc3\xbcber")
    assert done.returncode == 1
    assert (
        "which the locale's encoding cannot hold; a UTF-8 locale, or PYTHONUTF8=1," in done.stderr
    )
    assert len(done.stderr.splitlines()) == 1


def test_words_beyond_ascii_are_written_as_utf_8(tmp_path) -> None:
    folder = write_sound(tmp_path)
    for number in range(EPISODES):
        words = {"language_instruction": np.array("Berühre den Würfel.")}
        np.savez_compressed(folder / f"train_data_{number}.npz", **arrays_of(number) | words)
    done = convert(tmp_path, os.fsencode(tmp_path))
    assert done.returncode == 0, done.stderr
    card = (tmp_path / "data_lerobot" / ID / "README.md").read_text("utf-8")
    assert "Berühre den Würfel." in card
