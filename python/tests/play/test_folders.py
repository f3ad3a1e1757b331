"""Folders of the command line: checks before anything is shown, and nothing under a wrong name."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from play_server import SECONDS, serving

from engram._io import documents
from engram.play.folders import Demonstrations, Results, SourceError, open_folder

TASK = "RememberColor3-VLA-v0"
PIPE_POLICY = Path(__file__).parents[2] / "examples" / "pipe_policy.py"


def engram_command(*arguments) -> None:
    command = [sys.executable, "-m", "engram", *map(str, arguments)]
    subprocess.run(command, check=True, capture_output=True, timeout=SECONDS)


@pytest.fixture(scope="module")
def written(tmp_path_factory) -> Path:
    """A run of engram's sweep, and demonstrations."""
    out = tmp_path_factory.mktemp("written")
    words = ("--policy=sweep", "--obs=state", "--episodes=2")
    engram_command("eval", TASK, *words, "--out", out / "results")
    engram_command("collect", TASK, "--episodes=1", "--out", out / "data")
    return out


@pytest.fixture
def run(written: Path, tmp_path) -> Path:
    (settings,) = written.rglob("settings.json")
    return Path(shutil.copytree(settings.parent, tmp_path / "run"))


def changed(file: Path, old: str, new: str) -> None:
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1))


def rewritten(file: Path, **values) -> None:
    """Changes values of a document; its checksum fits."""
    file.write_text(documents.to_text({**json.loads(file.read_text()), **values}))


def test_results_of_eval_are_accepted(run: Path):
    assert isinstance(open_folder(run), Results)
    rewritten(run / f"{TASK}.json")  # by another writer of JSON
    assert isinstance(open_folder(run), Results)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('"successes": [', '"successes": [ '),
        ('"episode_lengths"', '"episode_lengths" '),
    ],
)
def test_spaces_change_no_checksum(run: Path, old, new):
    changed(run / f"{TASK}.json", old, new)
    assert isinstance(open_folder(run), Results)


def test_results_that_were_changed_are_refused(run: Path):
    file = run / f"{TASK}.json"
    good = file.read_text()
    seeds = json.loads(good)["episode_seeds"]
    for old, new in (
        (str(seeds[0]), str(seeds[0] + 1)),
        ("true", "false") if "true" in good else ("false", "true"),
        ('"checksum"', '"checksums"'),
    ):
        file.write_text(good)
        changed(file, old, new)
        with pytest.raises(SourceError, match="edited"):
            open_folder(run)


@pytest.mark.parametrize("name", ["settings.json", f"{TASK}.json"])
def test_results_of_another_version_are_refused(run: Path, name):
    rewritten(run / name, version="0.4.0")
    with pytest.raises(SourceError, match=r"is of engram 0\.4\.0, and this is engram"):
        open_folder(run)


def test_demonstrations_of_another_version_are_refused(written: Path, tmp_path):
    data = Path(shutil.copytree(written / "data", tmp_path / "data"))
    assert isinstance(open_folder(data), Demonstrations)
    (file,) = data.rglob("metadata.json")
    document = json.loads(file.read_text())
    document["engram"]["version"] = "0.3.0"
    rewritten(file, engram=document["engram"])
    with pytest.raises(SourceError, match=r"0\.3\.0|checksum"):
        open_folder(data)


def test_a_task_under_another_name_is_refused(run: Path):
    rewritten(run / "settings.json", tasks=["ShellGameTouch-VLA-v0"])
    (run / f"{TASK}.json").rename(run / "ShellGameTouch-VLA-v0.json")
    with pytest.raises(SourceError, match="env_id"):
        open_folder(run)


def test_a_foreign_policy_is_never_shown_as_one_of_engrams_own(tmp_path):
    """It had one of their names, before eval refused that."""
    policy = f"{sys.executable} {PIPE_POLICY}"
    engram_command(
        "eval", TASK, "--policy-command", policy, "--episodes=1", "--out", tmp_path / "results"
    )
    (settings,) = tmp_path.rglob("settings.json")
    rewritten(settings, policy="oracle")
    with serving(tmp_path / "out", "--folder", settings.parent) as server, server.page() as page:
        page.receive("hello")
        page.send("stored", folder=0, task=0, episode=0)
        with pytest.raises(AssertionError, match="has to be given again: --policy-command"):
            page.receive("playback")


def test_names_of_folders_are_printable(run: Path):
    other = run.with_name("run\u202e\x1b")
    run.rename(other)
    assert open_folder(other).message()["name"] == "run\\u202e\\x1b"


def test_a_repeated_episode_that_ends_otherwise_is_said_to_differ(run: Path, tmp_path):
    document = json.loads((run / f"{TASK}.json").read_text())
    with serving(tmp_path / "out", "--folder", run) as server, server.page() as page:
        page.send("stored", folder=0, task=0, episode=0)
        assert not page.receive("playback")["differs"]
    successes = [not one for one in document["successes"]]
    rewritten(run / f"{TASK}.json", successes=successes)
    with serving(tmp_path / "out", "--folder", run) as server, server.page() as page:
        page.send("stored", folder=0, task=0, episode=0)
        assert page.receive("playback")["differs"]
