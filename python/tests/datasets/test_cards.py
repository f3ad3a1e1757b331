"""Cards of converted data sets: true, and enough to make the set again."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from demonstrations import IDS
from sound_dataset import ID, metadata_text, sound_metadata, write_sound

pytest.importorskip("pyarrow")
pytest.importorskip("av")

from engram.datasets import find_folders, lerobot, rlds

BIN = Path(sys.executable).parent


def commands(card: str) -> str:
    (block,) = re.findall(r"^```sh\n(.*?)^```$", card, re.MULTILINE | re.DOTALL)
    return block


def rows(card: str) -> dict[str, str]:
    return dict(re.findall(r"^\| (.+?) \| (.+) \|$", card, re.MULTILINE))


def contents(folder: Path) -> dict[str, bytes]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


def test_its_commands_make_the_same_set_again(demonstrations, tmp_path):
    folder = find_folders(demonstrations, [IDS[-1]])[0]
    options = {"version": "2.1", "fps": 10, "frames": "auto", "angles": "benchmark"}
    path = lerobot.convert(folder, tmp_path / "first", **options)
    # The command of the environment that runs this, instead of the one that PATH has.
    words = commands((path / "README.md").read_text()).replace(
        "engram collect", f"{sys.executable} -m engram collect"
    )
    environment = {**os.environ, "PATH": f"{BIN}:{os.environ['PATH']}"}
    done = subprocess.run(
        ["bash", "-euc", words], cwd=tmp_path, env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    again = tmp_path / "data"
    assert contents(again / "data_npz" / IDS[-1]) == contents(folder.path)
    assert contents(again / "data_lerobot" / IDS[-1]) == contents(path)


def test_its_figures_are_those_of_the_set(demonstrations, folder, tmp_path):
    cards = [
        (rlds.convert(folder, tmp_path, jobs=1) / "README.md").read_text(),
        (demonstrations / "data_lerobot" / folder.env_id / "README.md").read_text(),
    ]
    lengths, seeds = (folder.metadata[f"episode_{name}s"] for name in ("length", "seed"))
    for card in cards:
        facts = rows(card)
        assert facts["episodes"] == str(len(folder))
        assert facts["frames"] == f"{sum(lengths):,}"
        assert facts["frames per episode"].startswith(f"{min(lengths)} to {max(lengths)}, ")
        assert facts["seeds"] == f"{min(seeds)} to {max(seeds)}"
        assert facts["control steps per second"] == "20"
        assert facts["licence"] == "apache-2.0"
        assert facts["version of engram"] == folder.metadata["engram"]["version"]
        for episode in folder:
            assert f"* {episode.language_instruction}\n" in card
        assert card.startswith("---\nlicense: apache-2.0\n")
    assert "roll is from 0 to 2 pi" in cards[1]
    assert "from -pi to pi" in cards[0]


@pytest.mark.parametrize(
    ("origin", "words"),
    [
        ({"player": "engram play"}, "It was played with engram play"),
        ({"rules": "a\nb | <script>"}, "| rules | a b \\| &lt;script> |"),
        ({"rules": "$(rm -rf .)"}, "--rules '$(rm -rf .)'"),
    ],
)
def test_foreign_words_stay_words(tmp_path, origin, words):
    folder = write_sound(tmp_path)
    document = sound_metadata()
    document["engram"] |= origin
    (folder / "metadata.json").write_text(metadata_text(document))
    path = lerobot.convert(find_folders(tmp_path)[0], tmp_path, frames="images")
    card = (path / "README.md").read_text()
    assert words in card
    assert ("engram collect" in card) == ("player" not in origin)
    assert f"# Demonstrations of {ID}\n" in card
