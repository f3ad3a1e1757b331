"""Programs of scripts/ and tools/: --help, changelog fragments, and subjects of commits."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
import changelog  # noqa: E402
import commit_subject  # noqa: E402

sys.path.pop(0)

CHANGELOG = """# Changelog

## 0.6.0 (unreleased)

### Tasks and rules

* A task.

### Batches

* A batch.

## 0.5.0 (2026-11-30)

### Evaluation

* A result.
"""


@pytest.fixture
def repository(tmp_path: Path) -> Path:
    (tmp_path / "changelog.d").mkdir()
    (tmp_path / "changelog.d" / "README.md").write_text("# Changelog fragments\n")
    (tmp_path / "CHANGELOG.md").write_text(CHANGELOG)
    return tmp_path


def add(repository: Path, name: str, text: str) -> None:
    (repository / "changelog.d" / name).write_text(text)


def test_fragments_of_this_repository_are_well_formed() -> None:
    changelog.main([])


def test_fragments_move_into_the_first_version(repository: Path) -> None:
    add(repository, "tasks.push.md", "* A second task\n  with a name.\n")
    add(repository, "evaluation.seeds.md", "* Seeds.\n")
    changelog.main(["--build", "--root", str(repository)])
    text = (repository / "CHANGELOG.md").read_text()
    assert "* A task.\n* A second task\n  with a name.\n\n### Batches\n" in text
    assert "* A batch.\n\n### Evaluation\n\n* Seeds.\n\n## 0.5.0 (2026-11-30)\n" in text
    assert text.endswith("### Evaluation\n\n* A result.\n")
    assert [file.name for file in (repository / "changelog.d").iterdir()] == ["README.md"]


@pytest.mark.parametrize(
    ("name", "text", "problem"),
    [
        ("tasks.md", "* A task.\n", r"tasks\.md: SECTION\.NAME\.md needed; sections: physics, "),
        ("others.push.md", "* A task.\n", r"others\.push\.md: SECTION\.NAME\.md needed"),
        ("tasks.push.md", "A task.\n", r"tasks\.push\.md:1: '\* ' or two spaces, and text needed"),
        ("tasks.push.md", "* A task.\n\n* Seeds.\n", r"tasks\.push\.md:2: '\* ' or two spaces"),
        ("tasks.push.md", f"* {'a' * 130}.\n", r"tasks\.push\.md:1: 133 characters; 130 allowed"),
        ("tasks.push.md", "* A task\n* Seeds.\n", r"a point ends without a full stop"),
        ("tasks.push.md", "", r"tasks\.push\.md:1: '\* ' or two spaces"),
    ],
)
def test_ill_formed_fragments_are_refused(
    repository: Path, name: str, text: str, problem: str
) -> None:
    add(repository, name, text)
    for arguments in ([], ["--build"]):
        with pytest.raises(SystemExit, match=problem):
            changelog.main([*arguments, "--root", str(repository)])
    assert (repository / "CHANGELOG.md").read_text() == CHANGELOG


def test_fragments_need_an_unreleased_version(repository: Path) -> None:
    released = CHANGELOG.replace("(unreleased)", "(2026-12-24)")
    (repository / "CHANGELOG.md").write_text(released)
    add(repository, "tasks.push.md", "* A task.\n")
    with pytest.raises(SystemExit, match=r"'## 0\.6\.0 \(2026-12-24\)' is first"):
        changelog.main(["--build", "--root", str(repository)])
    assert (repository / "changelog.d" / "tasks.push.md").exists()


@pytest.mark.parametrize(
    "message",
    [
        "Merge BatchGroup into Batch\n",
        "Add a hook\n\nWhy it is needed.\n",
        f"Add {'a' * 68}",
        "fixup! Add a hook\n",
        "Add a hook\n# Please enter the commit message\n",
        'Revert "Add a hook"\n',
    ],
)
def test_imperative_subjects_are_accepted(tmp_path: Path, message: str) -> None:
    (tmp_path / "message").write_text(message)
    commit_subject.main([str(tmp_path / "message")])


@pytest.mark.parametrize(
    ("message", "problem"),
    [
        ("Added a hook\n", r"'Added' given first, a verb of tools/commit_verbs\.txt needed"),
        ("Contacts: a hook\n", "'Contacts:' given first"),
        ("add a hook\n", "'add' given first"),
        ("\n", "'' given first"),
        (f"Add {'a' * 69}", "73 characters given, 72 allowed"),
        ("Add a hook.\n", "a full stop given"),
        ("Add a hook\nand more\n", "a second line given"),
    ],
)
def test_other_subjects_are_refused(tmp_path: Path, message: str, problem: str) -> None:
    (tmp_path / "message").write_text(message)
    with pytest.raises(SystemExit, match=problem):
        commit_subject.main([str(tmp_path / "message")])


SCRIPTS = [f for f in sorted((ROOT / "scripts").glob("*.sh")) if f.read_text().startswith("#!")]


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.name)
def test_help_of_scripts_prints_their_comment_alone(script: Path, tmp_path: Path) -> None:
    """It needs nothing but bash, dirname and sed, so it neither installs nor builds."""
    for tool in ("bash", "dirname", "sed"):
        (tmp_path / tool).symlink_to(f"/usr/bin/{tool}")
    for option in ("--help", "-h"):
        done = subprocess.run(
            [tmp_path / "bash", script, option],
            env={"PATH": str(tmp_path)},
            capture_output=True,
            text=True,
            check=False,
        )
        assert (done.returncode, done.stderr) == (0, "")
        comment = script.read_text().split("\n\n")[0].split("\nset ")[0].splitlines()[1:]
        assert done.stdout.splitlines() == [line.removeprefix("#")[1:] for line in comment]


@pytest.mark.parametrize("tool", sorted((ROOT / "tools").glob("*.py")), ids=lambda tool: tool.name)
def test_help_of_tools(tool: Path) -> None:
    done = subprocess.run(
        [sys.executable, tool, "--help"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("usage: ")
